// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fstream>
#include <optional>
#include <string>

#include "support.h"
#include "task_scene_graph/language/vocabulary.h"

namespace tsg::language::test {

/// CLIP's vocabulary: as installed, else from the shared test data, else nothing.
inline std::optional<std::string> findClipVocabulary() {
  if (const auto installed = findInstalledVocabulary()) return installed;
  const auto shared = tsg::test::findSharedFolder();
  if (!shared) return std::nullopt;
  const auto path = *shared / "data" / "clip" / "bpe_simple_vocab_16e6.txt.gz";
  if (!std::filesystem::exists(path)) return std::nullopt;
  return path.string();
}

inline void writeFile(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

}  // namespace tsg::language::test

/// Skips the running gtest case unless CLIP's vocabulary is here; else sets `variable` to its path.
#define TSG_REQUIRE_VOCABULARY(variable)                                                  \
  const auto variable##_found = tsg::language::test::findClipVocabulary();                \
  if (!variable##_found)                                                                  \
    GTEST_SKIP() << "CLIP's vocabulary is not here (scripts/install_vocabulary gets it)"; \
  const std::string& variable = *variable##_found
