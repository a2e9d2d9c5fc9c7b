// SPDX-License-Identifier: BSD-3-Clause
#include "sequence.h"

#include <array>
#include <cstdio>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

namespace tsg::test {
namespace fs = std::filesystem;
namespace {

template <std::size_t Count>
std::array<double, Count> readNumbers(const fs::path& path) {
  std::ifstream file(path);
  std::array<double, Count> numbers{};
  for (double& number : numbers) file >> number;
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return numbers;
}

fs::path framePath(const fs::path& folder, int index, const char* suffix) {
  std::array<char, 64> name{};
  std::snprintf(name.data(), name.size(), "frame-%06d.%s", index, suffix);
  return folder / name.data();
}

cv::Mat readImage(const fs::path& path, int flags) {
  cv::Mat image = cv::imread(path.string(), flags);
  if (image.empty()) throw std::runtime_error("cannot read " + path.string());
  return image;
}

}  // namespace

RgbdFrame loadSequenceFrame(const fs::path& folder, int index) {
  RgbdFrame frame;
  frame.stamp = Stamp::fromSeconds(index / 30.0);
  frame.color.stamp = frame.stamp;
  frame.color.order = ColorOrder::kBgr;
  frame.color.image = readImage(framePath(folder, index, "color.jpg"), cv::IMREAD_COLOR);
  frame.depth.image = readImage(framePath(folder, index, "depth.png"), cv::IMREAD_UNCHANGED);
  const auto k = readNumbers<9>(folder / "camera-intrinsics.txt");
  frame.camera = {frame.depth.image.cols, frame.depth.image.rows, k[0], k[4], k[2], k[5]};
  const auto pose = readNumbers<16>(framePath(folder, index, "pose.txt"));
  frame.T_world_camera.matrix() =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(pose.data());
  return frame;
}

cv::Mat loadSequenceLabels(const fs::path& folder, int index) {
  return readImage(framePath(folder, index, "labels.png"), cv::IMREAD_UNCHANGED);
}

}  // namespace tsg::test
