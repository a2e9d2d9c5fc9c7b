// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "task_scene_graph/core/mesh.h"

namespace tsg::mapping {

/// Writes a mesh as binary little-endian PLY: vertices x, y, z (float, metres), red, green, blue
/// (uchar), faces as lists of int. The file appears under its name only once it is complete.
/// @throws std::runtime_error that names the file if it cannot be written;
/// std::invalid_argument if there is not one colour per vertex.
void writePly(const std::filesystem::path& path, const Mesh& mesh);

/// The same with one more vertex property, `int object_id`.
/// @throws as above, and if there is not one id per vertex.
void writePly(const std::filesystem::path& path, const Mesh& mesh,
              const std::vector<std::int32_t>& object_ids);

}  // namespace tsg::mapping
