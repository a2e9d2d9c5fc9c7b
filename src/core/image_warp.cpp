// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/image_warp.h"

#include <opencv2/imgproc.hpp>

namespace tsg {
namespace {

/// Row of source coordinates along one axis.
cv::Mat computeCoordinates(int from, int to) {
  cv::Mat row(1, to, CV_32FC1);
  const double step = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    row.at<float>(i) = static_cast<float>((i + 0.5) * step - 0.5);
  }
  return row;
}

}  // namespace

ImageWarp ImageWarp::resize(cv::Size from, cv::Size to) {
  cv::Mat source_x;
  cv::Mat source_y;
  cv::repeat(computeCoordinates(from.width, to.width), to.height, 1, source_x);
  cv::repeat(computeCoordinates(from.height, to.height).t(), 1, to.width, source_y);
  return {source_x, source_y, from};
}

ImageWarp ImageWarp::followedBy(const ImageWarp& next) const {
  const cv::Scalar outside = cv::Scalar::all(-1e6);
  cv::Mat source_x;
  cv::Mat source_y;
  cv::remap(source_x_, source_x, next.source_x_, next.source_y_, cv::INTER_LINEAR,
            cv::BORDER_CONSTANT, outside);
  cv::remap(source_y_, source_y, next.source_x_, next.source_y_, cv::INTER_LINEAR,
            cv::BORDER_CONSTANT, outside);
  return {source_x, source_y, source_size_};
}

cv::Mat ImageWarp::applyNearest(const cv::Mat& source) const {
  cv::Mat result;
  cv::remap(source, result, source_x_, source_y_, cv::INTER_NEAREST, cv::BORDER_CONSTANT);
  return result;
}

cv::Mat ImageWarp::applyLinear(const cv::Mat& source) const {
  cv::Mat result;
  cv::remap(source, result, source_x_, source_y_, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return result;
}

}  // namespace tsg
