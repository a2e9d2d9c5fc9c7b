// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace tsg::test {

/// Folder of the optional test data (recorded sequences, network weights): $TSG_SHARED, else
/// ../shared beside the repository; nothing if neither is there.
std::optional<std::filesystem::path> findSharedFolder();

/// A fresh folder under the system's temporary folder, removed with everything in it at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace tsg::test

/// Skips the running gtest case, saying why, unless shared/<relative> exists; else sets `variable`
/// to it.
#define TSG_REQUIRE_SHARED(variable, relative)                                                   \
  const auto variable##_root = tsg::test::findSharedFolder();                                    \
  if (!variable##_root || !std::filesystem::exists(*variable##_root / (relative)))               \
    GTEST_SKIP() << "test data '" << (relative) << "' is not here (set TSG_SHARED to its root)"; \
  const std::filesystem::path variable = *variable##_root / (relative)
