// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "task_scene_graph/core/box.h"
#include "task_scene_graph/core/embedding.h"
#include "task_scene_graph/scene_graph/scoring.h"

namespace tsg::scene_graph {

/// What object primitives are together, in a map as in a scene graph file: the hull of their boxes,
/// the means of their positions and of their embeddings. Sums run in double precision in the order
/// of the calls.
class PrimitiveUnion {
 public:
  /// @param position_m  world frame; of our own primitives the centre of the box
  /// @param box         world frame, metres; an empty one does not count
  /// @param embedding   of the size of the others
  void add(const Eigen::Vector3d& position_m, const Aabb& box, const Embedding& embedding) {
    position_sum_m_ += position_m;
    if (!box.isEmpty()) box_.extend(box);
    embedding_.add(embedding);
    ++count_;
  }

  const Aabb& box() const { return box_; }
  /// The origin if nothing was added.
  Eigen::Vector3d position_m() const { return position_sum_m_ / std::max(count_, 1); }
  /// Empty if nothing was added.
  Embedding embedding() const { return embedding_.mean(); }

 private:
  Aabb box_;
  Eigen::Vector3d position_sum_m_ = Eigen::Vector3d::Zero();
  EmbeddingMean embedding_;
  int count_ = 0;
};

}  // namespace tsg::scene_graph
