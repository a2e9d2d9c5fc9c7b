// SPDX-License-Identifier: BSD-3-Clause
#include "object_volume.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "task_scene_graph/mapping/block_selector.h"

namespace tsg::mapping {
namespace {

/// Grows `extent` by the object's points in this view. Returns how many there are.
int addPoints(const ObjectConfig& config, const ObjectView& view, Aabb& extent) {
  const cv::Rect rect = findLabel(view.labels, view.segment);
  int count = 0;
  for (int v = rect.y; v < rect.y + rect.height; ++v) {
    const auto* labels = view.labels.ptr<std::uint16_t>(v);
    for (int u = rect.x; u < rect.x + rect.width; ++u) {
      if (labels[u] != view.segment) continue;
      const double z_m = view.frame.depth.at(u, v);
      if (z_m <= 0.0 || z_m < config.min_range_m || z_m > config.max_range_m) continue;
      extent.extend(view.frame.T_world_camera * view.frame.camera.unproject(u, v, z_m));
      ++count;
    }
  }
  return count;
}

}  // namespace

cv::Rect findLabel(const cv::Mat& labels, std::uint16_t segment) {
  int u_min = labels.cols;
  int u_max = -1;
  int v_min = labels.rows;
  int v_max = -1;
  for (int v = 0; v < labels.rows; ++v) {
    const auto* row = labels.ptr<std::uint16_t>(v);
    const auto* end = row + labels.cols;
    const auto* first = std::find(row, end, segment);
    if (first == end) continue;
    const auto* last = end - 1;
    while (*last != segment) --last;
    u_min = std::min(u_min, static_cast<int>(first - row));
    u_max = std::max(u_max, static_cast<int>(last - row));
    v_min = std::min(v_min, v);
    v_max = v;
  }
  return u_max < 0 ? cv::Rect() : cv::Rect(u_min, v_min, u_max - u_min + 1, v_max - v_min + 1);
}

ObjectView::ObjectView(const RgbdFrame& frame_in, const cv::Mat& labels_in,
                       std::uint16_t segment_in)
    : frame(frame_in), labels(labels_in), segment(segment_in) {
  frame.validate();
  if (labels.type() == CV_16UC1 && labels.size() == frame.depth.image.size()) return;
  throw std::invalid_argument("label image is " + std::to_string(labels.cols) + "x" +
                              std::to_string(labels.rows) + " of OpenCV type " +
                              cv::typeToString(labels.type()) +
                              ", expected CV_16UC1 of the frame's size");
}

DepthImage ObjectView::computeMaskedDepth() const {
  // A new cv::Mat: assigning zeros to a copy would overwrite the pixels that it shares.
  cv::Mat image(frame.depth.image.size(), frame.depth.image.type(), cv::Scalar(0));
  frame.depth.image.copyTo(image, labels == segment);
  return {image, frame.depth.metres_per_unit, nullptr};
}

void ObjectView::crop(const cv::Rect& rect) {
  frame.color.image = frame.color.image(rect);
  frame.depth.image = frame.depth.image(rect);
  labels = labels(rect);
  frame.camera.width_px = rect.width;
  frame.camera.height_px = rect.height;
  frame.camera.cx_px -= rect.x;
  frame.camera.cy_px -= rect.y;
}

void ObjectView::cropTo(const Aabb& box, double margin_m) {
  const Pose T_camera_world = frame.T_world_camera.inverse();
  const Aabb grown(box.min().array() - margin_m, box.max().array() + margin_m);
  Eigen::AlignedBox2d pixels;
  for (int i = 0; i < 8; ++i) {
    const auto corner = static_cast<Aabb::CornerType>(i);
    const Eigen::Vector3d p_camera = T_camera_world * grown.corner(corner);
    if (p_camera.z() < 0.05) return;  // the camera is within or beside the box: keep all
    pixels.extend(frame.camera.project(p_camera));
  }
  const Eigen::Vector2d size(frame.camera.width_px, frame.camera.height_px);
  const Eigen::Vector2i from = pixels.min().cwiseMax(0.0).cwiseMin(size).cast<int>();
  const Eigen::Vector2i to =
      (pixels.max().array() + 2.0).matrix().cwiseMax(0.0).cwiseMin(size).cast<int>();
  if ((to.array() <= from.array()).any()) return;
  crop({from.x(), from.y(), to.x() - from.x(), to.y() - from.y()});
}

Aabb computeExtent(const ObjectConfig& config, std::vector<ObjectView>& views) {
  Aabb extent;
  std::vector<ObjectView> usable;
  for (const auto& view : views) {
    Aabb seen;
    if (addPoints(config, view, seen) < config.min_pixels) continue;
    extent.extend(seen);
    usable.push_back(view);
  }
  views = std::move(usable);
  return extent;
}

ObjectVolume::ObjectVolume(const ObjectConfig& config, double voxel_size_m)
    : config_(config), tsdf_(voxel_size_m) {}

void ObjectVolume::assignDepth(const DepthImage& depth, int tile_px) {
  depth_.assign(depth, config_.min_range_m, config_.max_range_m, tile_px);
}

void ObjectVolume::allocate(const ObjectView& view) {
  BlockSelector::Options options;
  options.block_size_m = tsdf_.voxelSize() * kBlockSide;
  options.truncation_m = truncation();
  assignDepth(
      view.computeMaskedDepth(),
      BlockSelector::computeTileSide(view.frame.camera, options.block_size_m, config_.max_range_m));
  BlockSelector selector;
  const auto& selected =
      selector.select(depth_, view.frame.camera, view.frame.T_world_camera, options);
  for (const auto& index : selected) {
    if (tsdf_.findBlock(index) != nullptr) continue;
    blocks_.push_back(&tsdf_.allocateBlock(index));
    counts_.emplace_back();
  }
}

void ObjectVolume::integrate(const ObjectView& view) {
  assignDepth(view.frame.depth, std::max(view.frame.camera.width_px, view.frame.camera.height_px));
  const FrameView camera(view.frame, depth_, tsdf_.voxelSize(), true);
  UpdateRule rule;
  rule.truncation_m = static_cast<float>(truncation());
  rule.drop_off_start_m = static_cast<float>(tsdf_.voxelSize());
  rule.weight_at_1m =
      camera.fx_px * camera.fy_px * static_cast<float>(tsdf_.voxelSize() * tsdf_.voxelSize());
  SliceView slice;
  SliceUpdate update;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    TsdfBlock& block = *blocks_[i];
    const auto origins = computeSliceOrigins(camera, tsdf_.voxelSize(), block.index);
    for (std::size_t z = 0; z < kBlockSide; ++z) {
      if (!viewSlice(camera, origins[z], slice)) continue;
      const std::size_t first = z * kSliceVoxels;
      updateDistances(rule, slice, &block.voxels[first], update);
      updateColors(camera, slice, update, &block.colors[first]);
      countLabels(view, slice, update, first, counts_[i]);
    }
  }
}

void ObjectVolume::countLabels(const ObjectView& view, const SliceView& slice,
                               const SliceUpdate& update, std::size_t first_voxel,
                               LabelCounts& counts) const {
  for (std::size_t i = 0; i < kSliceVoxels; ++i) {
    if (update.in_band[i] == 0) continue;
    const int v = slice.pixel[i] / view.labels.cols;
    const int u = slice.pixel[i] % view.labels.cols;
    const bool is_object = view.labels.ptr<std::uint16_t>(v)[u] == view.segment;
    auto& count = (is_object ? counts.object : counts.other)[first_voxel + i];
    if (count < 65535) ++count;
  }
}

void ObjectVolume::removeBackground() {
  const auto free_m = static_cast<float>(truncation());
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    for (std::size_t voxel = 0; voxel < kBlockVoxels; ++voxel) {
      const int object = counts_[i].object[voxel];
      const int all = object + counts_[i].other[voxel];
      float& distance_m = blocks_[i]->voxels[voxel].distance_m;
      const bool is_background = distance_m <= 0.0F && object < config_.min_object_share * all;
      if (is_background || all < config_.min_voxel_observations) distance_m = free_m;
    }
  }
}

}  // namespace tsg::mapping
