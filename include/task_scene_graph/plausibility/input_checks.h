// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "task_scene_graph/core/camera.h"
#include "task_scene_graph/plausibility/finding.h"

namespace tsg::plausibility {

/// Frame ids in the headers of messages that belong together; "" = unknown.
struct FrameIds {
  std::string color;
  std::string depth;
  std::string camera_info;
};

/// A line for depth and one for camera_info, if stamped with another frame than colour. A leading
/// slash makes no difference.
std::vector<Finding> checkFrameIds(const FrameIds& ids);

/// What became of the colour images.
struct MatchCounts {
  std::uint64_t color_images = 0;
  std::uint64_t unmatched = 0;  ///< of these, without a depth image within the tolerance
  /// Least distance between an unmatched colour image's stamp and a depth image's.
  std::optional<double> nearest_unmatched_s;
  double tolerance_s = 0.0;
};

/// Nothing below 20 images, or if less than a fifth of them is unmatched.
std::optional<Finding> checkMatches(const MatchCounts& counts);

/// Principal point and field of view beside the size of the image.
std::optional<Finding> checkIntrinsics(const CameraModel& camera);

}  // namespace tsg::plausibility
