// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace task_scene_graph::scene_graph {

/// Replaces a file's content so that a reader, or a crash, sees the old or the new content, never a
/// part: writes `<path>.tmp-<pid>-<n>` in the same folder, syncs it to the disk, renames it.
/// @throws std::runtime_error naming the path and the system's reason; nothing is left behind then.
void writeFileAtomically(const std::string& path, const std::string& content);

}  // namespace task_scene_graph::scene_graph
