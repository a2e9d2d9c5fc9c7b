// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/video/tracking.hpp>

#include "task_scene_graph/core/frame.h"

namespace tsg::segmentation {

/// Where the pixels of an image were in the image before. Coarse: known on a grid of at most 160
/// columns, and without scale, so good for a few images on end.
struct ImageMotion {
  cv::Mat origins_px;  ///< CV_32FC2, grid: in the image before, in its pixels; empty = not known
  cv::Mat is_known;    ///< CV_8UC1, grid: 255 = the origin lies inside and looks the same
  cv::Size image_size_px;

  bool isEmpty() const { return origins_px.empty(); }
  /// Share of the image whose origin is known, in [0, 1]; 0 if empty.
  double computeKnownShare() const;
};

/// Dense optical flow from each image to the next (DIS [Kroeger16], on small grey images, without
/// the spatial propagation that would make it depend on the number of threads). O(pixels).
/// Thread safety: one thread.
class MotionEstimator {
 public:
  MotionEstimator();

  /// Since the image of the last call; empty for the first one and after another size.
  ImageMotion update(const ColorImage& color);

 private:
  cv::Ptr<cv::DISOpticalFlow> flow_;
  cv::Mat before_;  ///< CV_8UC1, small
  cv::Size image_size_px_;
};

/// The labels of the image before, each where its pixels are now; 0 where nothing is known of them.
/// O(pixels). @param labels CV_16UC1 of the motion's image size.
cv::Mat moveLabels(const cv::Mat& labels, const ImageMotion& motion);

/// Entry (a, b) = pixels with label a in one and b in the other image, both CV_16UC1 of one size;
/// labels up to the numbers given. Reads every second pixel of every second row and
/// counts it four times. O(pixels / 4).
Eigen::MatrixXi countCommonPixels(const cv::Mat& labels_a, std::size_t num_a,
                                  const cv::Mat& labels_b, std::size_t num_b);

}  // namespace tsg::segmentation
