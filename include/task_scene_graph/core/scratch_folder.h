// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace tsg {

/// A folder of this process's own for as long as it lives: `task_scene_graph_<process>_XXXXXX`.
/// Making one removes those that processes left which were killed. They are known by a lock that
/// ends with its process, so that what another container uses, whose processes are not seen from
/// here, is left alone.
class ScratchFolder {
 public:
  /// @param parent  where it is made. @throws std::runtime_error naming it and the system's reason.
  explicit ScratchFolder(
      const std::filesystem::path& parent = std::filesystem::temp_directory_path());
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;  ///< the folder, open and locked
};

}  // namespace tsg
