// SPDX-License-Identifier: BSD-3-Clause
#include "recorded_sequence.h"

#include <cstdio>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

namespace task_scene_graph::test {
namespace fs = std::filesystem;
namespace {

cv::Mat readImage(const fs::path& path, int flags) {
  cv::Mat image = cv::imread(path.string(), flags);
  if (image.empty()) throw std::runtime_error("cannot read image " + path.string());
  return image;
}

template <int kRows, int kCols>
Eigen::Matrix<double, kRows, kCols> readMatrix(const fs::path& path) {
  std::ifstream file(path);
  Eigen::Matrix<double, kRows, kCols> matrix;
  for (int row = 0; row < kRows; ++row) {
    for (int col = 0; col < kCols; ++col) file >> matrix(row, col);
  }
  if (!file) throw std::runtime_error("cannot read matrix " + path.string());
  return matrix;
}

}  // namespace

RecordedSequence::RecordedSequence(const fs::path& folder) : folder_(folder) {
  const Eigen::Matrix3d k = readMatrix<3, 3>(folder_ / "camera-intrinsics.txt");
  std::ifstream file(folder_ / "timestamps.txt");
  for (double seconds = 0.0; file >> seconds;) stamps_.push_back(Stamp::fromSeconds(1.0 + seconds));
  if (stamps_.empty()) {
    for (std::size_t i = 0; fs::exists(nameOf(i, "pose.txt")); ++i) {
      stamps_.push_back(Stamp::fromSeconds(1.0 + static_cast<double>(i) / 30.0));
    }
  }
  const cv::Mat first = loadDepth(0);
  camera_ = {first.cols, first.rows, k(0, 0), k(1, 1), k(0, 2), k(1, 2)};
}

fs::path RecordedSequence::nameOf(std::size_t frame, const char* suffix) const {
  char name[64];
  std::snprintf(name, sizeof(name), "frame-%06zu.%s", frame, suffix);
  return folder_ / name;
}

Pose RecordedSequence::loadPose(std::size_t frame) const {
  return Pose(readMatrix<4, 4>(nameOf(frame, "pose.txt")));
}

cv::Mat RecordedSequence::loadDepth(std::size_t frame) const {
  return readImage(nameOf(frame, "depth.png"), cv::IMREAD_UNCHANGED);
}

cv::Mat RecordedSequence::loadLabels(std::size_t frame) const {
  return readImage(nameOf(frame, "labels.png"), cv::IMREAD_UNCHANGED);
}

cv::Mat RecordedSequence::loadColor(std::size_t frame) const {
  const fs::path jpeg = nameOf(frame, "color.jpg");
  return readImage(fs::exists(jpeg) ? jpeg : nameOf(frame, "color.png"), cv::IMREAD_COLOR);
}

RgbdFrame RecordedSequence::loadFrame(std::size_t frame, bool with_color) const {
  RgbdFrame result;
  result.stamp = stamp(frame);
  result.camera = camera_;
  result.T_world_camera = loadPose(frame);
  result.depth.image = loadDepth(frame);
  result.color.stamp = result.stamp;
  result.color.order = ColorOrder::kBgr;
  result.color.image =
      with_color ? loadColor(frame) : cv::Mat::zeros(result.depth.image.size(), CV_8UC3);
  return result;
}

}  // namespace task_scene_graph::test
