// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/depth_buffer.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "task_scene_graph/core/vectorize.h"

namespace tsg::mapping {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// As in DepthImage::at().
constexpr float kLargestRaw16 = 65534.5F;
constexpr float kLargestRaw32 = 1e6F;

struct Limits {
  float metres_per_unit;
  float min_m;
  float max_m;
  float invalid_from_m;
  float beyond_m;
};

Limits makeLimits(const DepthImage& depth, double min_range_m, double max_range_m,
                  double beyond_m) {
  const auto unit_m = static_cast<float>(depth.metres_per_unit);
  const float largest_raw = depth.image.depth() == CV_16U ? kLargestRaw16 : kLargestRaw32;
  return {unit_m, static_cast<float>(min_range_m), static_cast<float>(max_range_m),
          largest_raw * unit_m, static_cast<float>(beyond_m)};
}

inline float convertDepth(float raw, const Limits& limits) {
  const float z_m = raw * limits.metres_per_unit;
  const bool is_valid = (z_m > 0.0F) & (z_m >= limits.min_m) & (z_m < limits.invalid_from_m);
  const float limited_m = z_m <= limits.max_m ? z_m : limits.beyond_m;
  return is_valid ? limited_m : 0.0F;
}

}  // namespace

TSG_VECTORIZE void convertDepthRow16(const std::uint16_t* raw, const Limits& limits, int count,
                                     float* depth_m) {
  const Limits local = limits;
  for (int i = 0; i < count; ++i) depth_m[i] = convertDepth(static_cast<float>(raw[i]), local);
}

TSG_VECTORIZE void convertDepthRow32(const float* raw, const Limits& limits, int count,
                                     float* depth_m) {
  const Limits local = limits;
  for (int i = 0; i < count; ++i) depth_m[i] = convertDepth(raw[i], local);
}

TSG_VECTORIZE void updateColumnLimits(const float* depth_m, int count, float* min_m, float* max_m) {
  for (int i = 0; i < count; ++i) {
    const float z_m = depth_m[i];
    const float candidate_m = z_m > 0.0F ? z_m : kInfinity;
    min_m[i] = candidate_m < min_m[i] ? candidate_m : min_m[i];
    max_m[i] = z_m > max_m[i] ? z_m : max_m[i];
  }
}

void DepthBuffer::assign(const DepthImage& depth, double min_range_m, double max_range_m,
                         int tile_px, double beyond_m) {
  width_ = depth.image.cols;
  height_ = depth.image.rows;
  tile_px_ = tile_px;
  depth_m_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) + 1);
  depth_m_.back() = 0.0F;
  column_min_m_.assign(static_cast<std::size_t>(width_), kInfinity);
  column_max_m_.assign(static_cast<std::size_t>(width_), 0.0F);
  tile_min_m_.resize(static_cast<std::size_t>(tileColumns() * tileRows()));
  tile_max_m_.resize(tile_min_m_.size());
  const Limits limits = makeLimits(depth, min_range_m, max_range_m, beyond_m);
  for (int v = 0; v < height_; ++v) {
    float* row = depth_m_.data() + index(width_, 0, v);
    if (depth.image.depth() == CV_16U) {
      convertDepthRow16(depth.image.ptr<std::uint16_t>(v), limits, width_, row);
    } else {
      convertDepthRow32(depth.image.ptr<float>(v), limits, width_, row);
    }
    updateColumnLimits(row, width_, column_min_m_.data(), column_max_m_.data());
    if ((v + 1) % tile_px_ == 0 || v + 1 == height_) finishTileRow(v / tile_px_);
  }
}

void DepthBuffer::finishTileRow(int tile_row) {
  for (int column = 0; column < tileColumns(); ++column) {
    const auto begin = column * tile_px_;
    const auto end = std::min(begin + tile_px_, width_);
    const float min_m =
        *std::min_element(column_min_m_.begin() + begin, column_min_m_.begin() + end);
    const auto tile = index(tileColumns(), column, tile_row);
    tile_min_m_[tile] = min_m < kInfinity ? min_m : 0.0F;
    tile_max_m_[tile] =
        *std::max_element(column_max_m_.begin() + begin, column_max_m_.begin() + end);
  }
  std::fill(column_min_m_.begin(), column_min_m_.end(), kInfinity);
  std::fill(column_max_m_.begin(), column_max_m_.end(), 0.0F);
}

DepthLimits DepthBuffer::computeLimits(int u_px, int v_px, int side_px) const {
  float min_m = kInfinity;
  float max_m = 0.0F;
  for (int v = v_px; v < std::min(v_px + side_px, height_); ++v) {
    for (int u = u_px; u < std::min(u_px + side_px, width_); ++u) {
      const float z_m = at(u, v);
      min_m = z_m > 0.0F ? std::min(min_m, z_m) : min_m;
      max_m = std::max(max_m, z_m);
    }
  }
  return {max_m > 0.0F ? min_m : 0.0F, max_m};
}

bool DepthBuffer::hasValidDepth() const {
  return std::any_of(tile_max_m_.begin(), tile_max_m_.end(), [](float z_m) { return z_m > 0.0F; });
}

}  // namespace tsg::mapping
