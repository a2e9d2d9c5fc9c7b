// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "depth_grid.h"
#include "depth_statistics.h"
#include "task_scene_graph/plausibility/finding.h"

namespace tsg::plausibility {

/// How far poses have moved since the first one, and whether images change while they do not. To be
/// given a frame about four times a second. Not thread-safe.
class StillnessCheck {
 public:
  void add(const RgbdFrame& frame);  ///< must be usable (isUsable)

  /// "constant pose": in 18 of the last 20 images more than half of the depth readings differ from
  /// the first image's by more than a tenth, and the pose has never moved by 1 mm or 0.1 degrees.
  /// (Somebody who walks about before a camera that stands still hides less, and less often.)
  std::optional<Finding> findConstantPose() const;

  /// True if a flat wall would have been seen at changing depth: turned by 2 degrees, or gone
  /// forward by 5 cm, as the poses say.
  bool hasChangedView() const { return has_changed_view_; }

 private:
  static constexpr std::size_t kMemory = 20;

  std::optional<Pose> first_pose_;
  DepthGrid first_;
  bool has_moved_ = false;
  bool has_changed_view_ = false;
  std::deque<double> changed_shares_;
};

/// Counts colour images that are black. Not thread-safe.
class DarknessCheck {
 public:
  void add(const cv::Mat& color);
  /// "dark images": nine of ten images or more, of at least 10, are.
  std::optional<Finding> finding() const;

 private:
  std::size_t num_images_ = 0;
  std::size_t num_dark_ = 0;
};

/// "constant depth": every reading of every image is the same, and the view has changed.
std::optional<Finding> checkConstantDepth(const DepthStatistics& depth, bool has_changed_view);

}  // namespace tsg::plausibility
