// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/block_selector.h"

#include <algorithm>
#include <cmath>

namespace tsg::mapping {
namespace {

// Relative block coordinates are made positive by this, so that truncation rounds them down.
constexpr int kShift = 1 << 15;
// More than the rounding of single precision at kShift, in blocks.
constexpr float kRoundingMargin = 0.01F;

Eigen::Array4f toArray(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), 0.0F};
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
  const double wanted_px = 0.25 * block_size_m * camera.fx_px / max_range_m;
  int side_px = 1;  // a power of two, so that squares halve without overlap
  while (side_px < 16 && 2 * side_px <= wanted_px) side_px *= 2;
  return side_px;
}

const std::vector<GridIndex>& BlockSelector::select(const DepthBuffer& depth,
                                                    const CameraModel& camera,
                                                    const Pose& T_world_camera,
                                                    const Options& options) {
  options_ = options;
  set_.clear();
  latest_.clear();
  setView(camera, T_world_camera);
  const int side_px = depth.tileSide();
  for (int row = 0; row < depth.tileRows(); ++row) {
    for (int column = 0; column < depth.tileColumns(); ++column) {
      const DepthLimits limits{depth.tileMin(column, row), depth.tileMax(column, row)};
      if (limits.max_m > 0.0F) addSquare(depth, column * side_px, row * side_px, side_px, limits);
    }
  }
  return set_.indices();
}

void BlockSelector::setView(const CameraModel& camera, const Pose& T_world_camera) {
  const double blocks_per_m = 1.0 / options_.block_size_m;
  const Eigen::Vector3d camera_in_blocks = T_world_camera.translation() * blocks_per_m;
  const Eigen::Vector3d first = camera_in_blocks.array().floor();
  first_block_ = first.cast<int>().array() - kShift;
  origin_ = toArray(camera_in_blocks - first) + static_cast<float>(kShift);
  const Eigen::Matrix3d rotation = blocks_per_m * T_world_camera.linear();
  direction_ = toArray(rotation * camera.unproject(0.0, 0.0, 1.0));
  direction_per_u_ = toArray(rotation.col(0) / camera.fx_px);
  direction_per_v_ = toArray(rotation.col(1) / camera.fy_px);
  half_width_per_m_ =
      static_cast<float>(M_SQRT1_2 * blocks_per_m / std::min(camera.fx_px, camera.fy_px));
}

void BlockSelector::addSquare(const DepthBuffer& depth, int u_px, int v_px, int side_px,
                              const DepthLimits& limits) {
  const bool is_one_ray = side_px == 1 || options_.carve_free_space ||
                          limits.max_m - limits.min_m <= 2.0 * options_.truncation_m;
  if (is_one_ray) {
    const float half_px = 0.5F * static_cast<float>(side_px - 1);
    addRay(static_cast<float>(u_px) + half_px, static_cast<float>(v_px) + half_px, side_px, limits);
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

void BlockSelector::addRay(float u_px, float v_px, int side_px, const DepthLimits& limits) {
  const auto truncation_m = static_cast<float>(options_.truncation_m);
  const float far_m = limits.max_m + truncation_m;
  const float near_m = options_.carve_free_space
                           ? std::min(static_cast<float>(options_.min_range_m), limits.min_m)
                           : std::max(0.0F, limits.min_m - truncation_m);
  addSegment(direction_ + u_px * direction_per_u_ + v_px * direction_per_v_, near_m, far_m,
             half_width_per_m_ * static_cast<float>(side_px) * far_m + kRoundingMargin);
}

void BlockSelector::addSegment(const Eigen::Array4f& direction, float near_m, float far_m,
                               float margin) {
  // Pieces of half a block, because the box round a long slanted segment holds blocks far from it.
  const auto pieces =
      static_cast<std::size_t>(2.0F * (far_m - near_m) * direction.abs().maxCoeff()) + 1;
  if (latest_.size() < pieces) {
    latest_.resize(pieces, {Eigen::Array4i::Constant(1), Eigen::Array4i::Zero()});
  }
  const Eigen::Array4f step = (far_m - near_m) / static_cast<float>(pieces) * direction;
  Eigen::Array4f a = origin_ + near_m * direction;
  for (std::size_t i = 0; i < pieces; ++i) {
    const Eigen::Array4f b = a + step;
    const BlockBox box{(a.min(b) - margin).cast<int>(), (a.max(b) + margin).cast<int>()};
    a = b;
    BlockBox& latest = latest_[i];
    if ((box.min == latest.min).all() && (box.max == latest.max).all()) continue;
    latest = box;
    addBox(box);
  }
}

void BlockSelector::addBox(const BlockBox& box) {
  for (int z = box.min.z(); z <= box.max.z(); ++z) {
    for (int y = box.min.y(); y <= box.max.y(); ++y) {
      for (int x = box.min.x(); x <= box.max.x(); ++x) {
        set_.insert(first_block_ + GridIndex(x, y, z));
      }
    }
  }
}

}  // namespace tsg::mapping
