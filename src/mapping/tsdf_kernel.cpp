// SPDX-License-Identifier: BSD-3-Clause
// Every loop here runs over the 64 voxels of a slice without branches, so that the compiler turns
// it into vector instructions. Reading the images is the exception and has loops of its own.
#include "tsdf_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "task_scene_graph/core/vectorize.h"

namespace tsg::mapping {
namespace {

constexpr float kMinVoxelDepth_m = 0.01F;

using SliceColors = std::array<std::uint32_t, kSliceVoxels>;

/// The pixels of voxels in the band, each as the number whose low 24 bits are its three bytes.
void readColors(const cv::Mat& image, const SliceView& slice, const SliceUpdate& update,
                SliceColors& pixels) {
  const auto last = static_cast<std::int32_t>(3 * image.total()) - 4;
  const std::uint8_t* bytes = image.ptr();
  for (std::size_t i = 0; i < kSliceVoxels; ++i) {
    if (update.in_band[i] == 0) continue;
    const std::int32_t wanted = 3 * slice.pixel[i];
    const std::int32_t offset = std::min(wanted, last);  // four bytes are read, not three
    std::uint32_t value = 0;
    std::memcpy(&value, bytes + offset, 4);
    pixels[i] = value >> (8 * ((wanted - offset) & 3));
  }
}

}  // namespace

FrameView::FrameView(const RgbdFrame& frame, const DepthBuffer& depth, double voxel_size_m,
                     bool with_color)
    : depth_m(depth.data()),
      width_px(depth.width()),
      height_px(depth.height()),
      fx_px(static_cast<float>(frame.camera.fx_px)),
      fy_px(static_cast<float>(frame.camera.fy_px)),
      cx_px(static_cast<float>(frame.camera.cx_px + 0.5)),
      cy_px(static_cast<float>(frame.camera.cy_px + 0.5)),
      T_camera_world(frame.T_world_camera.inverse()) {
  const bool has_color = with_color && frame.color.image.total() > 1;
  if (has_color) {
    color = frame.color.image.isContinuous() ? frame.color.image : frame.color.image.clone();
  }
  if (frame.color.order == ColorOrder::kBgr) std::swap(red_shift, blue_shift);
  const Eigen::Matrix3d steps = voxel_size_m * T_camera_world.linear();
  for (int i = 0; i < kSliceVoxels; ++i) {
    const Eigen::Vector3f offset =
        (steps.col(0) * (i % kBlockSide) + steps.col(1) * (i / kBlockSide)).cast<float>();
    const auto lane = static_cast<std::size_t>(i);
    offset_x_m[lane] = offset.x();
    offset_y_m[lane] = offset.y();
    offset_z_m[lane] = offset.z();
  }
}

std::array<Eigen::Vector3f, kBlockSide> computeSliceOrigins(const FrameView& frame,
                                                            double voxel_size_m,
                                                            const GridIndex& block) {
  std::array<Eigen::Vector3f, kBlockSide> origins;
  const Eigen::Vector3d first = (block.cast<double>() * kBlockSide).array() + 0.5;
  Eigen::Vector3d p_camera = frame.T_camera_world * Eigen::Vector3d(voxel_size_m * first);
  const Eigen::Vector3d step = voxel_size_m * frame.T_camera_world.linear().col(2);
  for (auto& origin : origins) {
    origin = p_camera.cast<float>();
    p_camera += step;
  }
  return origins;
}

TSG_VECTORIZE void projectSlice(const FrameView& frame, const Eigen::Vector3f& first,
                                SliceView& slice) {
  const float x0 = first.x();
  const float y0 = first.y();
  const float z0 = first.z();
  const float fx = frame.fx_px;
  const float fy = frame.fy_px;
  const float cx = frame.cx_px;
  const float cy = frame.cy_px;
  const auto width = static_cast<float>(frame.width_px);
  const auto height = static_cast<float>(frame.height_px);
  const std::int32_t stride = frame.width_px;
  const std::int32_t outside = frame.width_px * frame.height_px;
  for (std::size_t i = 0; i < kSliceVoxels; ++i) {
    const float z = z0 + frame.offset_z_m[i];
    const float inverse_z = 1.0F / z;
    const float x = (x0 + frame.offset_x_m[i]) * inverse_z;
    const float y = (y0 + frame.offset_y_m[i]) * inverse_z;
    const float u = x * fx + cx;
    const float v = y * fy + cy;
    const bool inside =
        (z > kMinVoxelDepth_m) & (u >= 0.0F) & (u < width) & (v >= 0.0F) & (v < height);
    const auto column = static_cast<std::int32_t>(inside ? u : 0.0F);
    const auto row = static_cast<std::int32_t>(inside ? v : 0.0F);
    slice.z_m[i] = z;
    slice.ray[i] = std::sqrt(1.0F + x * x + y * y);
    slice.pixel[i] = inside ? row * stride + column : outside;
  }
}

TSG_VECTORIZE std::int32_t countValid(const std::array<float, kSliceVoxels>& depth_m) {
  std::int32_t count = 0;
  for (std::size_t i = 0; i < kSliceVoxels; ++i) count += depth_m[i] > 0.0F ? 1 : 0;
  return count;
}

bool viewSlice(const FrameView& frame, const Eigen::Vector3f& first_voxel_camera_m,
               SliceView& slice) {
  projectSlice(frame, first_voxel_camera_m, slice);
  for (std::size_t i = 0; i < kSliceVoxels; ++i) slice.depth_m[i] = frame.depth_m[slice.pixel[i]];
  return countValid(slice.depth_m) > 0;
}

TSG_VECTORIZE void updateDistances(const UpdateRule& rule, const SliceView& slice,
                                   TsdfVoxel* __restrict voxels, SliceUpdate& __restrict update) {
  const float truncation = rule.truncation_m;
  const float drop_off_slope = 1.0F / (truncation - rule.drop_off_start_m);
  const float constant = rule.constant_weight;
  const float scale = rule.weight_at_1m;
  const float max_range = rule.max_range_m;
  const float max_weight = rule.max_weight;
  for (std::size_t i = 0; i < kSliceVoxels; ++i) {
    const float depth = slice.depth_m[i];
    const float z = slice.z_m[i];
    const float distance = (depth - z) * slice.ray[i];
    const float clamped = distance < truncation ? distance : truncation;
    const float drop_off = (distance + truncation) * drop_off_slope;
    const float base = constant + scale / (z * z * z * z);
    // A reading beyond the range tells only of the space within it.
    const bool in_range = (depth <= max_range) | (z <= max_range);
    const bool valid = (depth > 0.0F) & (distance > -truncation) & in_range;
    const float reading_weight = valid ? base * (drop_off < 1.0F ? drop_off : 1.0F) : 0.0F;

    const float old_distance = voxels[i].distance_m;
    const float old_weight = voxels[i].weight;
    const float weight = old_weight + reading_weight;
    const float share = reading_weight / weight;
    // [Curless and Levoy 1996, Eq. 3]: D' = (W D + w d) / (W + w)
    const float mixed = old_distance + (clamped - old_distance) * share;
    voxels[i].distance_m = valid ? mixed : old_distance;
    // [Curless and Levoy 1996, Eq. 4]: W' = W + w; deviation: capped
    voxels[i].weight = weight < max_weight ? weight : max_weight;

    const float old_or_new = old_weight > 0.0F ? mixed : -truncation;
    update.share[i] = share;
    update.observed[i] = valid ? 1 : 0;
    update.changed[i] = valid & (old_or_new < truncation) ? 1 : 0;
    update.in_band[i] = valid & (distance < truncation) ? 1 : 0;
  }
}

TSG_VECTORIZE std::int32_t computeSum(const std::array<std::int32_t, kSliceVoxels>& values) {
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < kSliceVoxels; ++i) sum += values[i];
  return sum;
}

TSG_VECTORIZE void blendColors(const SliceUpdate& update, const SliceColors& pixels, int red_shift,
                               int blue_shift, std::uint32_t* colors) {
  for (std::size_t i = 0; i < kSliceVoxels; ++i) {
    const std::uint32_t old = colors[i];
    const std::uint32_t pixel = pixels[i];
    const float share = (old >> 24) != 0 ? update.share[i] : 1.0F;
    const auto mix = [share](std::uint32_t from, std::uint32_t to) {
      const auto old_value = static_cast<float>(static_cast<std::int32_t>(from & 255U));
      const auto new_value = static_cast<float>(static_cast<std::int32_t>(to & 255U));
      return static_cast<std::uint32_t>(
          static_cast<std::int32_t>(old_value + (new_value - old_value) * share + 0.5F));
    };
    const std::uint32_t mixed = mix(old, pixel >> red_shift) | mix(old >> 8, pixel >> 8) << 8 |
                                mix(old >> 16, pixel >> blue_shift) << 16 | 0xFF000000U;
    colors[i] = update.in_band[i] != 0 ? mixed : old;
  }
}

void updateColors(const FrameView& frame, const SliceView& slice, const SliceUpdate& update,
                  VoxelColor* colors) {
  static_assert(sizeof(VoxelColor) == sizeof(std::uint32_t));
  if (frame.color.empty() || computeSum(update.in_band) == 0) return;
  SliceColors pixels{};
  SliceColors blended;
  readColors(frame.color, slice, update, pixels);
  std::memcpy(blended.data(), colors, sizeof(blended));
  blendColors(update, pixels, frame.red_shift, frame.blue_shift, blended.data());
  std::memcpy(static_cast<void*>(colors), blended.data(), sizeof(blended));
}

BlockUpdate updateBlock(const FrameView& frame, const UpdateRule& rule, double voxel_size_m,
                        TsdfBlock& block) {
  const auto origins = computeSliceOrigins(frame, voxel_size_m, block.index);
  SliceView slice;
  SliceUpdate update;
  BlockUpdate total;
  for (std::size_t z = 0; z < kBlockSide; ++z) {
    if (!viewSlice(frame, origins[z], slice)) continue;
    const std::size_t first = z * kSliceVoxels;
    updateDistances(rule, slice, &block.voxels[first], update);
    updateColors(frame, slice, update, &block.colors[first]);
    total.observed += computeSum(update.observed);
    total.changed += computeSum(update.changed);
  }
  return total;
}

}  // namespace tsg::mapping
