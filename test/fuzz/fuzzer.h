// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "mutator.h"

namespace tsg::fuzz {

/// What is fuzzed. An input has done no harm if `read` returns, or refuses it: by an exception
/// derived from std::exception, other than std::bad_alloc, whose text contains `source`.
struct Reader {
  std::string name;    ///< "scene_graph"
  std::string source;  ///< file or topic that refusals have to name
  std::function<std::string(Mutator&)> make;
  std::function<void(const std::string& input)> read;
};

/// A folder for the files that a reader is given; removed at the program's end.
const std::filesystem::path& scratchFolder();
std::string readFile(const std::filesystem::path& path);
/// Writes the file anew.
void writeFile(const std::filesystem::path& path, const std::string& content);

/// A reader of files: each input becomes the file `name` in the scratch folder.
Reader makeFileReader(const std::string& name, const std::string& file_name,
                      std::function<std::string(Mutator&)> make,
                      std::function<void(const std::string& path)> read);

/// The main program of a fuzzed reader.
///
///     fuzz_NAME [--runs N] [--seed S] [--first R] [--findings DIR] [--result XML] [INPUT...]
///
/// Reads N (2,000) mutated inputs, run R of seed S being the same at any time, or the files given.
/// A finding is a crash, a hang of over 10 s, memory beyond 1 GB, or a refusal that does not name
/// its source; its input is kept in DIR. Memory is limited to 8 GB, but not where a sanitizer
/// keeps an account of its own.
/// @return exit status: 0 no finding, 1 findings, 2 a wrong command line; a crash ends the program.
int runFuzzer(int argc, char** argv, const Reader& reader);

}  // namespace tsg::fuzz
