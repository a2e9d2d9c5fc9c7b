// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "task_scene_graph/core/files.h"
#include "task_scene_graph/scene_graph/file_objects.h"

namespace tsg::evaluation {

/// Writes predictions as the OpenLex3D benchmark reads them [Kassab25], into a folder that is made
/// if absent:
///
/// - `embeddings.npy`: N x D float32, unit length, a row for each object that has points,
/// - `index.npy`: P int64, the row of each point,
/// - `point_cloud.pcd`: P points x, y, z (float, metres) and rgb, binary.
///
/// Points of no object are left out: an index below 0 would be read as one from the end.
/// @param cell_m  of the points of an object that lie in one cell of a grid the first is kept; 0:
/// all
/// @returns what was written
/// @throws std::invalid_argument if no object has points, or embeddings differ in size or are 0;
/// std::runtime_error naming a file that cannot be written.
std::vector<WrittenFile> writeOpenLex3d(const std::filesystem::path& folder,
                                        const std::vector<scene_graph::FileObject>& objects,
                                        double cell_m = 0.0);

}  // namespace tsg::evaluation
