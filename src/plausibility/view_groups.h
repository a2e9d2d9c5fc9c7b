// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "depth_grid.h"

namespace tsg::plausibility {

struct StampedPose {
  Stamp stamp;
  Pose T_world_camera = Pose::Identity();
};

/// A sampled depth image with its pose as given.
struct SampledView {
  StampedPose pose;
  DepthGrid depth;
};

/// A view and up to three later ones from places farther and farther away from it.
struct ViewGroup {
  std::uint64_t id = 0;
  StampedPose source_pose;
  CameraModel camera;              ///< of the images
  std::vector<PixelDepth> source;  ///< points of the first view
  std::vector<SampledView> targets;
  int level = -1;  ///< of the last of them: 0 = moved by 1 degree or 2 cm, 4 = 16 degrees or 32 cm
  std::vector<StampedPose> poses;  ///< as given, from just before the first view to after the last

  /// The pose given for a time, interpolated; nothing if the poses round it are not here.
  std::optional<Pose> findPose(Stamp stamp) const;
};

/// Picks, out of a stream of posed frames, a bounded number of groups of views with motion between
/// them. A group's views are chosen when the pose given for the camera has moved from the first by
/// 1, 2, 4, 8, 16 degrees or 2, 4, 8, 16, 32 cm; the last three are kept. Then the next group
/// starts. When there are too many groups every second one is dropped, and new ones are started
/// half as often: the groups stay spread over the whole stream.
/// Memory: 16 groups of at most 3 grids of 160 x 120 readings, 4 MB. Not thread-safe.
class ViewGroups {
 public:
  static constexpr std::size_t kMaxGroups = 16;
  static constexpr int kGridWidth_px = 160;
  static constexpr double kMaxDelay_s = 0.5;

  /// `frame` must be usable (isUsable). A stamp that goes back ends the group at hand.
  /// @returns true if the frame was sampled as the first view of a group.
  bool add(const RgbdFrame& frame);

  const std::vector<ViewGroup>& groups() const { return groups_; }

 private:
  bool isOutgrown(const RgbdFrame& frame) const;
  void closeGroup();
  void startGroup(const RgbdFrame& frame);
  void extendGroup(const RgbdFrame& frame);
  void recordPose(const StampedPose& pose);
  void thinOut();

  std::vector<ViewGroup> groups_;
  bool is_open_ = false;  ///< the last group takes further views
  std::deque<StampedPose> recent_;
  std::uint64_t next_id_ = 1;
  double min_gap_s_ = 0.0;  ///< between the starts of groups
};

}  // namespace tsg::plausibility
