// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/core/mesh.h"
#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::mapping {

/// Surface (distance 0) of the cells whose lowest voxel lies in the block; a cell spans the centres
/// of 2 x 2 x 2 voxels, so the block's upper neighbours are read too. Only cells whose 8 voxels
/// all have a weight above `min_weight` give triangles [Lorensen and Cline 1987].
///
/// Vertices lie on the edges between voxel centres, by linear interpolation, in the world frame;
/// none occurs twice. Triangles are counter-clockwise seen from free space. Vertices that
/// neighbouring blocks share have the same bits in both: the blocks' meshes fit without a gap.
/// Colours are interpolated; a voxel without a colour takes no part. O(voxels of a block);
/// thread-safe while nobody changes the volume.
Mesh computeBlockMesh(const TsdfVolume& volume, const GridIndex& block, double min_weight);

/// Surface of the whole volume, blocks in ascending (z, y, x) order, welded across block borders.
Mesh computeMesh(const TsdfVolume& volume, double min_weight, int num_threads = 1);

/// The mesh with vertices at equal positions made one (the first one's colour stays) and triangles
/// that lost their area by that removed. O(vertices).
Mesh weldVertices(const Mesh& mesh);

}  // namespace tsg::mapping
