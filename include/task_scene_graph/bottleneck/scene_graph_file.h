// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "task_scene_graph/bottleneck/clustering.h"

namespace tsg::bottleneck {

/// A primitive of a scene graph file; its key is spark_dsg's 64-bit node id.
struct FilePrimitive {
  NodeKey id = 0;
  Embedding embedding;  ///< mean of the columns of `semantic_feature`
  Aabb box;             ///< world frame, metres; rotated boxes: their hull; empty if INVALID
};

/// A scene graph in spark_dsg's JSON, versions 1.0 (as Clio publishes them) and 1.1 (as the PyPI
/// package writes them). What a clustering does not touch stays as it was read.
class SceneGraphFile {
 public:
  /// @throws std::runtime_error naming the file, the node and what was expected if the file is
  /// missing, malformed, or a primitive has no box or no embedding.
  explicit SceneGraphFile(const std::string& path);
  ~SceneGraphFile();
  SceneGraphFile(SceneGraphFile&&) noexcept;
  SceneGraphFile& operator=(SceneGraphFile&&) noexcept;

  /// Nodes of the SEGMENTS layer, or of OBJECTS where that has none; in the file's order.
  const std::vector<FilePrimitive>& primitives() const;

  /// Makes one node of the OBJECTS layer of each cluster (a partition of the primitives): box =
  /// hull, position and embedding = mean, mesh = all meshes, name and semantic_label = task (name
  /// "" for the null task). Where the primitives are segments, the objects take the place of the
  /// OBJECTS layer's nodes, get ids O0, O1, ... by smallest segment, and are the segments' parents.
  /// Where they are objects, the smallest of a cluster stands for it and the others disappear.
  void replaceObjects(const std::vector<Cluster>& clusters,
                      const std::vector<std::string>& task_names);

  void write(std::ostream& out) const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

/// "s12 (8286623314361712652)": a node id as spark_dsg prints it, and as a number.
std::string describeNode(NodeKey id);

}  // namespace tsg::bottleneck
