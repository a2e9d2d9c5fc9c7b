// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "task_scene_graph/bottleneck/graph_types.h"
#include "task_scene_graph/core/embedding.h"
#include "task_scene_graph/core/rotated_box.h"

namespace tsg::scene_graph {

enum class FileLayer {
  kObjects,  ///< what a clustering made
  kSegments  ///< primitives
};

/// Where an object's box comes from.
enum class BoxSource {
  kFile,  ///< the box of least footprint that this package notes, else the node's bounding box
  kMesh   ///< the upright box of least footprint around the node's mesh
};

/// Whether the vertices of the nodes' meshes are wanted.
enum class MeshPoints { kLeave, kRead };

/// A node of a scene graph file that has a place in space and a meaning.
struct FileObject {
  bottleneck::NodeKey id = 0;
  std::string name;                       ///< of its task in files of this package; may be empty
  RotatedBox box;                         ///< world frame
  Embedding embedding;                    ///< mean of the columns of `semantic_feature`
  std::vector<Eigen::Vector3d> points_m;  ///< kRead: of its mesh, world frame
  std::vector<std::array<std::uint8_t, 3>> colors;  ///< RGB of each; grey where the file has none
};

struct FileObjects {
  std::vector<FileObject> objects;  ///< in the file's order
  /// Nodes of the layer that were left out, a line each: node and reason.
  std::vector<std::string> left_out;
};

/// The objects of a scene graph in spark_dsg's JSON, of this package or another; versions and forms
/// as SceneGraphFile reads them. Nodes without a readable box, mesh (kMesh: of more than three
/// vertices) or embedding are left out and named. A node without a mesh has no points.
/// deviation: the authors' evaluation fits boxes of least volume to the meshes; here they stay
/// upright, as things stand.
/// @throws std::runtime_error naming the file and what was found if it is missing, no JSON, or no
/// scene graph.
FileObjects loadFileObjects(const std::string& path, FileLayer layer, BoxSource source,
                            MeshPoints points = MeshPoints::kLeave);

}  // namespace tsg::scene_graph
