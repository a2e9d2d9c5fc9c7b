// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

namespace tsg {

/// A path as people write it, absolute and without "." and "..": a leading `~` or `~user` is a home
/// folder, `$NAME` and `${NAME}` are environment variables, a leading `file://` is taken off (and
/// %20 and the like are decoded then), and what is relative lies below `folder`.
/// @param text    empty gives an empty path
/// @param folder  empty: the current folder
/// @throws std::invalid_argument naming the text: a variable that is not set, a user who is not
/// known, another scheme than file://, a substitution that only launch files know.
std::filesystem::path expandPath(const std::string& text, const std::filesystem::path& folder = {});

/// Checks that a regular file is there. @throws std::runtime_error "<what> '<path>': ..." with the
/// absolute path, and what is wrong with it: not there, a folder, not readable.
void requireFile(const std::string& what, const std::filesystem::path& path);

/// Writes a file so that it is there whole or not at all: `write` fills a temporary file in the
/// same folder, which is flushed to the disk and renamed to `path`. Parent folders are made, and
/// temporary files of `path` removed whose process is no more (it was killed while it wrote).
/// @throws std::runtime_error naming the path and the system's reason; the temporary file is
/// removed.
void writeFileAtomically(const std::filesystem::path& path,
                         const std::function<void(std::ostream&)>& write);

/// The same of a file that `write` opens itself, by the temporary name.
void replaceFile(const std::filesystem::path& path,
                 const std::function<void(const std::filesystem::path& temporary)>& write);

/// A file that a program wrote, and what it holds: {"mesh.ply", "120000 vertices"}.
struct WrittenFile {
  std::string name;
  std::string content;  ///< empty: there is nothing to say of it
};

/// "1 object", "2 objects", "0 primitives".
std::string formatCount(std::size_t count, const std::string& singular);

/// The line that a program ends with: "wrote /home/u/map: mesh.ply (120000 vertices),
/// settings.yaml"; "wrote /home/u/mesh.ply (120000 vertices)" for one file without a folder.
std::string describeWritten(const std::filesystem::path& folder,
                            const std::vector<WrittenFile>& files);

}  // namespace tsg
