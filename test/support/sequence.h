// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "task_scene_graph/core/frame.h"

namespace tsg::test {

/// Reads frame `index` of a folder in 7-Scenes layout (camera-intrinsics.txt, frame-%06d.color.jpg,
/// .depth.png in millimetres, .pose.txt). Stamps are index / 30 s. @throws std::runtime_error if a
/// file is absent.
RgbdFrame loadSequenceFrame(const std::filesystem::path& folder, int index);

/// The frame's label image (frame-%06d.labels.png, CV_16UC1).
cv::Mat loadSequenceLabels(const std::filesystem::path& folder, int index);

}  // namespace tsg::test
