// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/frame.h"

#include <sstream>
#include <stdexcept>

namespace tsg {
namespace {

template <typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  std::ostringstream message;
  (message << ... << parts);
  throw std::invalid_argument(message.str());
}

void requireSize(const char* what, const cv::Mat& image, const CameraModel& camera) {
  if (image.cols == camera.width_px && image.rows == camera.height_px) return;
  fail(what, " image is ", image.cols, "x", image.rows, ", expected the camera's ", camera.width_px,
       "x", camera.height_px);
}

void requireRigid(const Pose& pose) {
  if (!pose.matrix().allFinite()) fail("camera pose has a value that is not finite");
  const Eigen::Matrix3d rotation = pose.linear();
  const bool rigid =
      (rotation * rotation.transpose()).isIdentity(1e-3) && rotation.determinant() > 0;
  if (!rigid)
    fail("camera pose is not a rotation and translation (determinant ", rotation.determinant(),
         ", expected 1)");
}

}  // namespace

void RgbdFrame::validate() const {
  camera.validate();
  if (color.image.type() != CV_8UC3) {
    fail("colour image has OpenCV type ", cv::typeToString(color.image.type()),
         ", expected CV_8UC3");
  }
  if (depth.image.type() != CV_16UC1 && depth.image.type() != CV_32FC1) {
    fail("depth image has OpenCV type ", cv::typeToString(depth.image.type()),
         ", expected CV_16UC1 or CV_32FC1");
  }
  requireSize("colour", color.image, camera);
  requireSize("depth", depth.image, camera);
  requireRigid(T_world_camera);
}

void Segmentation::validate() const {
  if (labels.type() != CV_16UC1) {
    fail("label image has OpenCV type ", cv::typeToString(labels.type()), ", expected CV_16UC1");
  }
  if (confidences.size() != numSegments()) {
    fail("segmentation has ", confidences.size(), " confidences for ", numSegments(),
         " embeddings");
  }
  double largest = 0.0;
  if (!labels.empty()) cv::minMaxIdx(labels, nullptr, &largest);
  if (largest > static_cast<double>(numSegments())) {
    fail("label image holds label ", largest, ", but there are only ", numSegments(), " segments");
  }
  if (!embeddings.allFinite()) fail("a segment embedding has a value that is not finite");
  const bool comparable = image_embedding.size() == 0 || numSegments() == 0 ||
                          image_embedding.size() == embeddings.cols();
  if (!comparable) {
    fail("image embedding has ", image_embedding.size(), " values, segment embeddings have ",
         embeddings.cols());
  }
  if (!image_embedding.allFinite()) fail("the image embedding has a value that is not finite");
}

SegmentationPtr alignToFrame(const RgbdFrame& frame, const SegmentationPtr& segmentation) {
  if (!frame.color_warp || !segmentation) return segmentation;
  const cv::Size expected = frame.color_warp->sourceSize();
  if (segmentation->labels.size() != expected) {
    fail("label image is ", segmentation->labels.cols, "x", segmentation->labels.rows,
         ", expected that of the published colour image, ", expected.width, "x", expected.height);
  }
  auto aligned = std::make_shared<Segmentation>(*segmentation);
  aligned->labels = frame.color_warp->applyNearest(segmentation->labels);
  return aligned;
}

}  // namespace tsg
