// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "task_scene_graph/core/camera.h"
#include "task_scene_graph/core/embedding.h"
#include "task_scene_graph/core/image_warp.h"
#include "task_scene_graph/core/stamp.h"

namespace tsg {

/// Rigid transform. `T_a_b` maps coordinates in b to coordinates in a: p_a = T_a_b * p_b.
using Pose = Eigen::Isometry3d;

enum class ColorOrder { kRgb, kBgr };

/// A view of an 8-bit, 3-channel colour image. `image` borrows its pixels from `owner` (for
/// instance a sensor_msgs/Image), which keeps them alive: copying a ColorImage copies no pixel.
struct ColorImage {
  Stamp stamp;
  cv::Mat image;  ///< H x W, CV_8UC3
  ColorOrder order = ColorOrder::kRgb;
  std::shared_ptr<const void> owner;
};

/// A view of a depth image along the optical axis: CV_16UC1 or CV_32FC1. Invalid: 0, 65535 (16UC1),
/// NaN, infinite or negative (32FC1). Copying it copies no pixel.
struct DepthImage {
  cv::Mat image;
  double metres_per_unit = 0.001;  ///< 0.001 for 16UC1 millimetres, 1 for 32FC1 metres
  std::shared_ptr<const void> owner;

  /// Depth in metres at column u, row v; 0 where invalid.
  float at(int u_px, int v_px) const {
    if (image.depth() == CV_16U) {
      const std::uint16_t raw = image.ptr<std::uint16_t>(v_px)[u_px];
      return raw == 65535 ? 0.0F : static_cast<float>(raw * metres_per_unit);
    }
    const float raw = image.ptr<float>(v_px)[u_px];
    return raw > 0.0F && raw < 1e6F ? static_cast<float>(raw * metres_per_unit) : 0.0F;
  }
};

/// One registered RGB-D image with its pose. Colour and depth have the camera's size.
struct RgbdFrame {
  Stamp stamp;
  CameraModel camera;
  Pose T_world_camera = Pose::Identity();
  ColorImage color;
  DepthImage depth;
  /// How `color` was made of the image that the camera published (rectified, brought to the depth
  /// image's size); null where it is that image.
  ImageWarpPtr color_warp;
  /// The image as published, for a segmenter to look at; may be empty, always is without a warp.
  ColorImage published_color;

  /// @throws std::invalid_argument naming what is wrong (sizes, types, intrinsics, a pose that is
  /// not finite or not a rotation), the value and what was expected.
  void validate() const;
};

using RgbdFramePtr = std::shared_ptr<const RgbdFrame>;

/// What the segmenter says of one colour image. Segments are numbered from 1; label 0 is "no
/// segment".
struct Segmentation {
  Stamp stamp;                     ///< stamp of the colour image
  cv::Mat labels;                  ///< H x W, CV_16UC1, value s = segment s, 0 = none
  EmbeddingMatrix embeddings;      ///< S x D, row s-1 = segment s; a row of zeros = not embedded
  std::vector<float> confidences;  ///< S, in [0, 1]
  Embedding image_embedding;       ///< D, or empty
  std::shared_ptr<const void> owner;

  std::size_t numSegments() const { return static_cast<std::size_t>(embeddings.rows()); }

  /// @throws std::invalid_argument if labels are not 16UC1, a label exceeds S, or sizes disagree.
  void validate() const;
};

using SegmentationPtr = std::shared_ptr<const Segmentation>;

/// Segmentations are made of images as published: the same segments with their labels in the pixels
/// of `frame.color` (nearest neighbour). Returns `segmentation` itself where the frame has no warp.
/// @throws std::invalid_argument if the labels have not the size of the published image.
SegmentationPtr alignToFrame(const RgbdFrame& frame, const SegmentationPtr& segmentation);

}  // namespace tsg
