// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/plausibility/finding.h"

namespace tsg::plausibility {

/// Whether poses follow each other as those of a thing with mass do. Noise of its own in every
/// pose, or poses that are held until the next one comes, change speed from image to image by more
/// than the speed itself. Looks at the last 256 poses less than 0.25 s apart. Not thread-safe.
class PoseSmoothness {
 public:
  void add(Stamp stamp, const Pose& T_world_camera);

  /// Root mean squares over successive images, without the greatest tenth.
  struct Roughness {
    double step_m = 0.0;    ///< motion from one image to the next
    double jolt_m = 0.0;    ///< change of that motion
    double turn_rad = 0.0;  ///< the same for the rotation
    double twist_rad = 0.0;
    double held_share = 0.0;  ///< images whose pose is exactly that of the image before
  };
  Roughness computeRoughness() const;
  /// Jolts (twists) are more than 0.8 times as large as steps (turns), and than 12 mm (0.7
  /// degrees).
  bool isRough() const;

 private:
  struct Motion {
    double dt_s = 0.0;
    Eigen::Vector3d step_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  };
  struct Sample {
    double step_m, jolt_m, turn_rad, twist_rad;
    bool is_held;
  };
  static constexpr std::size_t kMemory = 256;

  std::optional<Stamp> last_stamp_;
  Pose last_pose_ = Pose::Identity();
  std::optional<Motion> last_motion_;
  std::deque<Sample> samples_;
};
/// "pose jitter": in words. To be said where poses are rough and images do not agree with them.
Finding describeRoughness(const PoseSmoothness::Roughness& roughness);

}  // namespace tsg::plausibility
