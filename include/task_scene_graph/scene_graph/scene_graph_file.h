// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <iosfwd>
#include <memory>
#include <string>
#include <unordered_set>
#include <vector>

#include "task_scene_graph/bottleneck/clustering.h"

namespace tsg::scene_graph {

using bottleneck::Cluster;
using bottleneck::NodeKey;

/// A primitive of a scene graph file; its key is spark_dsg's 64-bit node id.
struct FilePrimitive {
  NodeKey id = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< world frame
  Embedding embedding;  ///< mean of the columns of `semantic_feature`
  Aabb box;             ///< world frame, metres; rotated boxes: their hull; empty if INVALID
};

/// A scene graph in spark_dsg's JSON, versions 1.0 (as Clio publishes them: also without a header,
/// with flat meshes and boxes by their corners) and 1.1 (as the PyPI package writes them). What a
/// clustering does not touch stays as it was read, letter by letter: the file's text is kept, and
/// of its numbers only the primitives' boxes, positions and embeddings are read. Memory: the text,
/// the embeddings and the objects made.
///
/// A node of the layer to be clustered without an id, a box, an embedding or a position that can be
/// read is no primitive and stays as it is. Edges from or to nodes that are not there go; so do
/// edges that cannot be read, and meshes that cannot be read from the objects made of their nodes.
/// `notes` tells of all that.
class SceneGraphFile {
 public:
  /// @param embedding_size that a primitive's embedding must have, the tasks' for instance; 0: the
  /// commonest of the file.
  /// @throws std::runtime_error naming the file and what was found if it is missing, packed, no
  /// JSON, no scene graph, or none of the nodes to be clustered can be read.
  explicit SceneGraphFile(const std::string& path, Eigen::Index embedding_size = 0);
  ~SceneGraphFile();
  SceneGraphFile(SceneGraphFile&&) noexcept;
  SceneGraphFile& operator=(SceneGraphFile&&) noexcept;

  /// Nodes of the SEGMENTS layer, or of OBJECTS where that has none; in the file's order.
  const std::vector<FilePrimitive>& primitives() const;

  /// How many nodes of that layer stay as they are, being no primitives.
  std::size_t numLeftNodes() const;

  /// Ids of all nodes of the file, whatever their layer, also of those that cannot be clustered.
  std::unordered_set<NodeKey> nodeIds() const;

  /// What could not be read or kept, a line for each kind with its number and the first of them.
  std::vector<std::string> notes() const;

  /// Makes one node of the OBJECTS layer of each cluster (a partition of the primitives): box =
  /// hull, position and embedding = mean, mesh = all meshes, name and semantic_label = task (name
  /// "" for the null task). Where the primitives are segments, the objects take the place of the
  /// OBJECTS layer's nodes, get ids O0, O1, ... by smallest segment, and are the segments' parents.
  /// Where they are objects, the smallest of a cluster stands for it and the others disappear.
  /// O(n log n) but for the search of the nearest place, see PointIndex.
  /// @throws std::runtime_error naming the file if a part of it is not as spark_dsg writes it;
  /// std::invalid_argument naming a task whose name is not valid UTF-8.
  void replaceObjects(const std::vector<Cluster>& clusters,
                      const std::vector<std::string>& task_names);

  void write(std::ostream& out) const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

/// "s12 (8286623314361712652)": a node id as spark_dsg prints it, and as a number.
std::string describeNode(NodeKey id);

}  // namespace tsg::scene_graph
