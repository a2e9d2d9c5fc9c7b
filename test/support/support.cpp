// SPDX-License-Identifier: BSD-3-Clause
#include "support.h"

#include <unistd.h>

#include <atomic>
#include <cstdlib>

namespace tsg::test {
namespace fs = std::filesystem;

std::optional<fs::path> findSharedFolder() {
  if (const char* given = std::getenv("TSG_SHARED")) return fs::path(given);
  const fs::path beside = fs::path(TSG_SOURCE_DIR).parent_path() / "shared";
  if (fs::is_directory(beside)) return beside;
  return std::nullopt;
}

TemporaryFolder::TemporaryFolder() {
  static std::atomic<int> counter{0};
  path_ = fs::temp_directory_path() /
          ("tsg_test_" + std::to_string(getpid()) + "_" + std::to_string(counter++));
  fs::create_directories(path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace tsg::test
