// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "task_scene_graph/core/mesh.h"

namespace tsg::mapping {

/// Writes a mesh as binary little-endian PLY: vertices x, y, z (float, metres), red, green, blue
/// (uchar), faces as lists of int. Whole or not at all (core/files.h).
/// @throws std::runtime_error that names the file if it cannot be written;
/// std::invalid_argument if there is not one colour per vertex.
void writePly(const std::filesystem::path& path, const Mesh& mesh);

/// The same with one more vertex property, `int object_id`, and the name of the frame that the
/// vertices are in as a comment of the header ("comment frame map"; empty: none).
/// @throws as above, and if there is not one id per vertex.
void writePly(const std::filesystem::path& path, const Mesh& mesh,
              const std::vector<std::int32_t>& object_ids, const std::string& frame = "");

}  // namespace tsg::mapping
