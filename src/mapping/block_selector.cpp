// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/block_selector.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace task_scene_graph::mapping {
namespace {

// std::floor is a library call on the baseline x86-64.
int floorToInt(double value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < truncated ? 1 : 0);
}

GridIndex toGridIndex(const Eigen::Vector3d& p) {
  return {floorToInt(p.x()), floorToInt(p.y()), floorToInt(p.z())};
}

}  // namespace

void GridIndexSet::clear() {
  indices_.clear();
  std::fill(slots_.begin(), slots_.end(), 0U);
}

bool GridIndexSet::insert(const GridIndex& index) {
  if (2 * (indices_.size() + 1) > slots_.size()) grow();
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = GridIndexHash()(index) & mask;
  for (; slots_[slot] != 0; slot = (slot + 1) & mask) {
    if (indices_[slots_[slot] - 1] == index) return false;
  }
  indices_.push_back(index);
  slots_[slot] = static_cast<std::uint32_t>(indices_.size());
  return true;
}

void GridIndexSet::grow() {
  slots_.assign(std::max<std::size_t>(1024, 2 * slots_.size()), 0U);
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    std::size_t slot = GridIndexHash()(indices_[i]) & mask;
    while (slots_[slot] != 0) slot = (slot + 1) & mask;
    slots_[slot] = static_cast<std::uint32_t>(i + 1);
  }
}

int BlockSelector::computeTileSide(const CameraModel& camera, double block_size_m,
                                   double max_range_m) {
  const double side_px = 0.25 * block_size_m * camera.fx_px / max_range_m;
  return static_cast<int>(std::clamp(side_px, 1.0, 16.0));
}

const std::vector<GridIndex>& BlockSelector::select(const DepthBuffer& depth,
                                                    const CameraModel& camera,
                                                    const Pose& T_world_camera,
                                                    const Options& options) {
  options_ = options;
  camera_ = camera;
  T_world_camera_ = T_world_camera;
  set_.clear();
  latest_.clear();
  const int side_px = depth.tileSide();
  for (int row = 0; row < depth.tileRows(); ++row) {
    for (int column = 0; column < depth.tileColumns(); ++column) {
      const DepthLimits limits{depth.tileMin(column, row), depth.tileMax(column, row)};
      if (limits.max_m > 0.0F) addSquare(depth, column * side_px, row * side_px, side_px, limits);
    }
  }
  return set_.indices();
}

void BlockSelector::addSquare(const DepthBuffer& depth, int u_px, int v_px, int side_px,
                              const DepthLimits& limits) {
  const bool is_one_ray = side_px == 1 || options_.carve_free_space ||
                          limits.max_m - limits.min_m <= options_.truncation_m;
  if (is_one_ray) {
    addRay(u_px + 0.5 * (side_px - 1), v_px + 0.5 * (side_px - 1), side_px, limits);
    return;
  }
  const int half_px = (side_px + 1) / 2;
  for (int v = v_px; v < v_px + side_px; v += half_px) {
    for (int u = u_px; u < u_px + side_px; u += half_px) {
      const DepthLimits part = depth.computeLimits(u, v, half_px);
      if (part.max_m > 0.0F) addSquare(depth, u, v, half_px, part);
    }
  }
}

void BlockSelector::addRay(double u_px, double v_px, int side_px, const DepthLimits& limits) {
  const double far_m = limits.max_m + options_.truncation_m;
  const double near_m = options_.carve_free_space
                            ? std::min<double>(options_.min_range_m, limits.min_m)
                            : std::max(0.0, limits.min_m - options_.truncation_m);
  const Eigen::Vector3d direction = T_world_camera_.linear() * camera_.unproject(u_px, v_px, 1.0);
  addSegment(direction, near_m, far_m,
             M_SQRT1_2 * side_px / std::min(camera_.fx_px, camera_.fy_px));
}

void BlockSelector::addSegment(const Eigen::Vector3d& direction, double near_m, double far_m,
                               double half_width_at_1m) {
  // Short pieces, because the box around a long slanted segment holds blocks far from it.
  const double length_m = (far_m - near_m) * direction.cwiseAbs().maxCoeff();
  const auto pieces = static_cast<std::size_t>(std::ceil(length_m / (0.5 * options_.block_size_m)));
  if (latest_.size() < pieces) {
    const GridIndex none = GridIndex::Constant(std::numeric_limits<int>::max());
    latest_.resize(pieces, {none, none});
  }
  const Eigen::Vector3d start = T_world_camera_.translation() + near_m * direction;
  const Eigen::Vector3d step = (far_m - near_m) / static_cast<double>(pieces) * direction;
  const double blocks_per_m = 1.0 / options_.block_size_m;
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(half_width_at_1m * far_m);
  for (std::size_t i = 0; i < pieces; ++i) {
    const Eigen::Vector3d a = start + static_cast<double>(i) * step;
    const Eigen::Vector3d b = a + step;
    const BlockBox box{toGridIndex((a.cwiseMin(b) - margin) * blocks_per_m),
                       toGridIndex((a.cwiseMax(b) + margin) * blocks_per_m)};
    if (box.min == latest_[i].min && box.max == latest_[i].max) continue;
    latest_[i] = box;
    addBox(box);
  }
}

void BlockSelector::addBox(const BlockBox& box) {
  for (int z = box.min.z(); z <= box.max.z(); ++z) {
    for (int y = box.min.y(); y <= box.max.y(); ++y) {
      for (int x = box.min.x(); x <= box.max.x(); ++x) set_.insert({x, y, z});
    }
  }
}

}  // namespace task_scene_graph::mapping
