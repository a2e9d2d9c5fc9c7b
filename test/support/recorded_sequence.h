// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "task_scene_graph/core/frame.h"

namespace task_scene_graph::test {

/// An RGB-D sequence in a folder of the 7-Scenes layout: frame-%06d.color.jpg or .png, .depth.png
/// (16-bit millimetres), .pose.txt (camera to world), camera-intrinsics.txt, and where there are
/// any timestamps.txt (else 30 Hz) and frame-%06d.labels.png.
class RecordedSequence {
 public:
  /// @throws std::runtime_error naming the file that is missing or unreadable.
  explicit RecordedSequence(const std::filesystem::path& folder);

  std::size_t size() const { return stamps_.size(); }
  Stamp stamp(std::size_t frame) const { return stamps_.at(frame); }
  Pose loadPose(std::size_t frame) const;
  cv::Mat loadDepth(std::size_t frame) const;
  cv::Mat loadLabels(std::size_t frame) const;
  cv::Mat loadColor(std::size_t frame) const;

  /// Depth, pose and stamp; the colour image is black unless asked for.
  RgbdFrame loadFrame(std::size_t frame, bool with_color = false) const;

 private:
  std::filesystem::path nameOf(std::size_t frame, const char* suffix) const;

  std::filesystem::path folder_;
  CameraModel camera_;
  std::vector<Stamp> stamps_;
};

}  // namespace task_scene_graph::test
