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

GridIndex Deformation::cellOf(const Eigen::Vector3d& p_m) const {
  return (p_m / config_.cell_m).array().floor().cast<int>();
}

/// Those of its bounding box where these are few, else those of its vertices, some more than once.
std::vector<GridIndex> Deformation::findCells(const Mesh& mesh) const {
  constexpr double kManyCells = 64.0;
  std::vector<GridIndex> cells;
  if (mesh.vertices.empty()) return cells;
  const Aabb box = mesh.computeBounds();
  const GridIndex low = cellOf(box.min());
  const GridIndex size = cellOf(box.max()) - low + GridIndex::Ones();
  if (size.cast<double>().prod() <= kManyCells) {
    for (int i = 0; i < size.prod(); ++i) {
      cells.push_back(low +
                      GridIndex(i % size.x(), i / size.x() % size.y(), i / (size.x() * size.y())));
    }
    return cells;
  }
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    const GridIndex cell = cellOf(vertex.cast<double>());
    if (cells.empty() || cells.back() != cell) cells.push_back(cell);
  }
  return cells;
}

void Deformation::addCell(const GridIndex& index) {
  const auto [found, is_new] = cells_.try_emplace(index);
  if (!is_new) return;
  Cell& cell = found->second;
  cell.motion = cornerAt(index);
  cell.are_alike = true;
  const Eigen::Vector4d pivot = Eigen::Quaterniond(cell.motion.linear()).coeffs();
  for (int i = 0; i < 8; ++i) {
    const Pose& motion = cornerAt(index + GridIndex(i & 1, (i >> 1) & 1, i >> 2));
    cell.are_alike = cell.are_alike && motion.matrix() == cell.motion.matrix();
    cell.corners[static_cast<std::size_t>(i)] = toDualQuaternion(motion, pivot);
  }
  cell.is_still = cell.are_alike && isIdentity(cell.motion);
}

void Deformation::prepare(const Mesh& mesh) {
  for (const GridIndex& cell : findCells(mesh)) addCell(cell);
}

bool Deformation::moves(const Mesh& mesh) const {
  const auto cells = findCells(mesh);
  return !std::all_of(cells.begin(), cells.end(),
                      [&](const GridIndex& cell) { return cells_.at(cell).is_still; });
}

/// As blend(), without a pose for each point.
Eigen::Vector3d Deformation::movePoint(const Cell& cell, const Eigen::Vector3d& share,
                                       const Eigen::Vector3d& p_m) {
  if (cell.are_alike) return cell.motion * p_m;
  Eigen::Vector4d turn = Eigen::Vector4d::Zero();
  Eigen::Vector4d shift = Eigen::Vector4d::Zero();
  for (int i = 0; i < 8; ++i) {
    const double weight = ((i & 1) != 0 ? share.x() : 1.0 - share.x()) *
                          ((i & 2) != 0 ? share.y() : 1.0 - share.y()) *
                          ((i & 4) != 0 ? share.z() : 1.0 - share.z());
    const DualQuaternion& corner = cell.corners[static_cast<std::size_t>(i)];
    turn += weight * corner.turn;
    shift += weight * corner.shift;
  }
  const double norm = turn.norm();
  turn /= norm;
  shift /= norm;
  const Eigen::Vector3d u = turn.head<3>();
  const Eigen::Vector3d v = shift.head<3>();
  const Eigen::Vector3d turned_m = p_m + 2.0 * u.cross(u.cross(p_m) + turn.w() * p_m);
  return turned_m + 2.0 * (turn.w() * v - shift.w() * u + u.cross(v));  // 2 dual * conj(real)
}

bool Deformation::move(Mesh& mesh) const {
  bool has_moved = false;
  GridIndex last = GridIndex::Zero();
  const Cell* cell = nullptr;
  for (Eigen::Vector3f& vertex : mesh.vertices) {
    const Eigen::Vector3d p_m = vertex.cast<double>();
    const Eigen::Vector3d in_cells = p_m / config_.cell_m;
    const GridIndex index = in_cells.array().floor().cast<int>();
    if (cell == nullptr || index != last) cell = &cells_.at(index);
    last = index;
    if (cell->is_still) continue;
    vertex = movePoint(*cell, in_cells - index.cast<double>(), p_m).cast<float>();
    has_moved = true;
  }
  return has_moved;
}

bool Deformation::moveVertices(Mesh& mesh) {
  prepare(mesh);
  return move(mesh);
}

}  // namespace tsg::trajectory
