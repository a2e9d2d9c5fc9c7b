// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/deformation.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "task_scene_graph/config/config.h"

namespace tsg::trajectory {
namespace {

using mapping::GridIndex;
using Node = std::pair<Eigen::Vector3d, Pose>;

bool isIdentity(const Pose& pose) { return pose.matrix() == Pose::Identity().matrix(); }

/// A node by its distance.
struct Near {
  double distance_m = 0.0;
  const Node* node = nullptr;
};

/// The `count` nearest, nearest first; of several at one distance those first in the list.
std::vector<Near> findNearest(const std::vector<Node>& nodes, const Eigen::Vector3d& p_m,
                              std::size_t count) {
  std::vector<Near> nearest;
  const auto isNearer = [](const Near& a, const Near& b) {
    return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.node < b.node;
  };
  // False where this node and all behind it are too far away in x alone.
  const auto visit = [&](const Node& node) {
    const bool is_full = nearest.size() == count;
    if (is_full && std::abs(node.first.x() - p_m.x()) > nearest.back().distance_m) return false;
    const Near candidate{(node.first - p_m).norm(), &node};
    if (is_full && !isNearer(candidate, nearest.back())) return true;
    if (is_full) nearest.pop_back();
    nearest.insert(std::upper_bound(nearest.begin(), nearest.end(), candidate, isNearer),
                   candidate);
    return true;
  };
  const auto middle =
      std::lower_bound(nodes.begin(), nodes.end(), p_m.x(),
                       [](const Node& node, double x_m) { return node.first.x() < x_m; });
  auto right = middle;
  auto left = std::make_reverse_iterator(middle);
  bool goes_right = true;
  bool goes_left = true;
  while (goes_right || goes_left) {
    goes_right = goes_right && right != nodes.end() && visit(*right++);
    goes_left = goes_left && left != nodes.rend() && visit(*left++);
  }
  return nearest;
}

}  // namespace

Deformation::Deformation(const Keyframes& before, const Correction& correction,
                         const DeformationConfig& config)
    : config_(config), is_rigid_(correction.isRigid()) {
  config::validate(config, "deformation");
  if (before.isEmpty()) throw std::invalid_argument("there is no keyframe that a map could follow");
  for (const Keyframe& keyframe : before.list()) {
    nodes_.emplace_back(keyframe.T_world_camera.translation(), correction.at({{keyframe.id, 1.0}}));
  }
  std::stable_sort(nodes_.begin(), nodes_.end(),
                   [](const Node& a, const Node& b) { return a.first.x() < b.first.x(); });
}

Pose Deformation::motionAt(const Eigen::Vector3d& p_m) const {
  if (is_rigid_) return nodes_[0].second;
  const auto count = static_cast<std::size_t>(config_.num_keyframes);
  std::vector<Near> nearest = findNearest(nodes_, p_m, count + 1);
  const double reach_m = nearest.back().distance_m;
  if (nearest.size() > count) nearest.pop_back();
  std::vector<std::pair<Pose, double>> motions;
  double sum = 0.0;
  for (const Near& near : nearest) {
    const double share = 1.0 - near.distance_m / reach_m;
    const double weight = reach_m > 0.0 ? share * share : 1.0;
    if (weight > 0.0) motions.emplace_back(near.node->second, weight);
    sum += weight;
  }
  if (motions.empty()) return nearest[0].node->second;  // all at one distance
  for (auto& motion : motions) motion.second /= sum;
  return blend(motions);
}

const Pose& Deformation::cornerAt(const GridIndex& corner) {
  const auto [found, is_new] = corners_.try_emplace(corner);
  if (is_new) found->second = motionAt(corner.cast<double>() * config_.cell_m);
  return found->second;
}

const Deformation::Cell& Deformation::cellAt(const GridIndex& index) {
  const auto [found, is_new] = cells_.try_emplace(index);
  Cell& cell = found->second;
  if (!is_new) return cell;
  cell.are_alike = true;
  for (int i = 0; i < 8; ++i) {
    Pose& corner = cell.corners[static_cast<std::size_t>(i)];
    corner = cornerAt(index + GridIndex(i & 1, (i >> 1) & 1, i >> 2));
    cell.are_alike = cell.are_alike && corner.matrix() == cell.corners[0].matrix();
  }
  cell.is_still = cell.are_alike && isIdentity(cell.corners[0]);
  return cell;
}

Pose Deformation::blendCorners(const Cell& cell, const Eigen::Vector3d& share) const {
  if (cell.are_alike) return cell.corners[0];
  std::vector<std::pair<Pose, double>> motions;
  for (int i = 0; i < 8; ++i) {
    const double weight = ((i & 1) != 0 ? share.x() : 1.0 - share.x()) *
                          ((i & 2) != 0 ? share.y() : 1.0 - share.y()) *
                          ((i & 4) != 0 ? share.z() : 1.0 - share.z());
    if (weight > 0.0) motions.emplace_back(cell.corners[static_cast<std::size_t>(i)], weight);
  }
  return blend(motions);
}

bool Deformation::moveVertices(Mesh& mesh) {
  bool has_moved = false;
  for (Eigen::Vector3f& vertex : mesh.vertices) {
    const Eigen::Vector3d p_m = vertex.cast<double>();
    const Eigen::Vector3d in_cells = p_m / config_.cell_m;
    const GridIndex index = in_cells.array().floor().cast<int>();
    const Cell& cell = cellAt(index);
    if (cell.is_still) continue;
    vertex = (blendCorners(cell, in_cells - index.cast<double>()) * p_m).cast<float>();
    has_moved = true;
  }
  return has_moved;
}

}  // namespace tsg::trajectory
