// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace tsg::map {

/// Keeps other processes, and other threads, from saving into a folder. Where the file system knows
/// no locks it does nothing.
class FolderLock {
 public:
  enum class Kind {
    kShared,    ///< while reading
    kExclusive  ///< while writing
  };

  /// Waits for whoever holds it, 20 s at most. A folder that is not there is not locked.
  /// @throws std::runtime_error naming the folder if it is still held then.
  FolderLock(const std::filesystem::path& folder, Kind kind);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace tsg::map
