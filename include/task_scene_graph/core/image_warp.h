// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <opencv2/core.hpp>

namespace tsg {

/// Which point of a source image each pixel of an image comes from: a change of size, the removal
/// of a lens distortion, or one after the other. Pixel centres lie at whole numbers. Immutable.
class ImageWarp {
 public:
  /// @param source_x, source_y  H x W, CV_32FC1: column and row in the source, px
  ImageWarp(cv::Mat source_x, cv::Mat source_y, cv::Size source_size)
      : source_x_(std::move(source_x)), source_y_(std::move(source_y)), source_size_(source_size) {}

  /// The whole of the source, in another size: u_source = (u + 0.5) * from / to - 0.5.
  static ImageWarp resize(cv::Size from, cv::Size to);

  /// This warp first, then `next`, whose source has this warp's size.
  ImageWarp followedBy(const ImageWarp& next) const;

  cv::Size sourceSize() const { return source_size_; }
  cv::Size size() const { return source_x_.size(); }

  /// For labels and depth, whose values must not be mixed. Outside of the source: 0. O(pixels).
  cv::Mat applyNearest(const cv::Mat& source) const;
  /// For colour: bilinear. Outside of the source: 0. O(pixels).
  cv::Mat applyLinear(const cv::Mat& source) const;

 private:
  cv::Mat source_x_;
  cv::Mat source_y_;
  cv::Size source_size_;
};

using ImageWarpPtr = std::shared_ptr<const ImageWarp>;

}  // namespace tsg
