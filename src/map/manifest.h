// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "task_scene_graph/map/folder.h"

namespace tsg::map {

/// Below it lies what a map goes on from, for this package alone.
constexpr const char* kStateFolder = "state/";

/// @throws as readManifest().
Manifest readManifestFile(const std::filesystem::path& path);
/// @throws std::runtime_error naming the path.
void writeManifest(const std::filesystem::path& folder, const Manifest& manifest);

/// O(bytes). @throws as computeCrc32().
FileRecord describeFile(const std::filesystem::path& path);

}  // namespace tsg::map
