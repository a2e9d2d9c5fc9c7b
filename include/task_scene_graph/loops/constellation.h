// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"

namespace tsg::loops {

/// Something seen around a keyframe: where, and what it looks like.
struct Landmark {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Embedding embedding;
};

struct ConstellationConfig {
  double max_distance_error_m = 0.25;
  double min_cosine = 0.8;
  int min_landmarks = 4;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("max_distance_error_m", self.max_distance_error_m, {0.001, 10.0}, "m",
            "two pairs of landmarks agree if the distances within both places differ by no more");
    v.field("min_cosine", self.min_cosine, {-1.0, 1.0}, "",
            "landmarks whose embeddings are less alike are not the same");
    v.field("min_landmarks", self.min_landmarks, {3.0, 1000.0}, "",
            "a constellation of fewer says nothing of the pose");
  }
};

/// Landmarks of two places that can be the same, and the motion that brings one onto the other.
struct Constellation {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;  ///< indices into a and b; each once
  Pose T_a_b = Pose::Identity();                           ///< of least squares over the pairs
};

/// The largest set of pairs found that agree with each other: alike by their embeddings, and with
/// the same distances within a as within b. Greedy from each pair in turn, those that most agree
/// first; a largest set is NP-hard to find. Fewer than `min_landmarks`, or all nearly on a line:
/// no pairs. O(P^3) for P pairs that look alike, at most 300 of them, the most alike.
Constellation matchConstellation(const std::vector<Landmark>& a, const std::vector<Landmark>& b,
                                 const ConstellationConfig& config);

/// Landmarks with those of `more` joined: what looks alike (`min_cosine`) and lies within
/// `radius_m` is one, in their middle. O(landmarks^2).
void joinLandmarks(const std::vector<Landmark>& more, double radius_m, double min_cosine,
                   std::vector<Landmark>& landmarks);

}  // namespace tsg::loops
