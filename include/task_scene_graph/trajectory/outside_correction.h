// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/trajectory/correction.h"

namespace tsg::trajectory {

/// How a trajectory from outside becomes a correction.
struct OutsideCorrectionConfig {
  KeyframeConfig keyframes;
  double max_gap_s = 1.0;
  double max_motion_m = 50.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.group("keyframes", self.keyframes);
    v.field("max_gap_s", self.max_gap_s, {0.0, 3600.0}, "s",
            "corrected poses at moments where the map's own poses are further apart are passed "
            "over");
    v.field("max_motion_m", self.max_motion_m, {0.0, 1e6}, "m",
            "a correction that moves the camera farther anywhere is refused");
  }
};

/// A correction, and the keyframes that it speaks of where they were before.
struct OutsideCorrection {
  Keyframes before;
  Correction correction;
  double max_motion_m = 0.0;  ///< of a keyframe
  double max_turn_rad = 0.0;  ///< of a keyframe
};

/// What a SLAM system's newest poses say of a map. Keyframes are taken at the stamps of its poses,
/// where these are exact, each `keyframes` apart, and wherever the motion changes; the map's own
/// poses, which are denser, are interpolated there:
///
///     T_new_old = corrected(stamp) * reported(stamp)^-1
///
/// Less than 1e-9 m and rad is the identity. O((own + corrected) log own).
/// @param own        the camera's way that the map was built with, T_world_camera
/// @param reported   the way before of the body whose way `corrected` is; of the camera: `own`
/// @param corrected  in the same frame as `reported`
/// @param frame      its name
/// @throws std::invalid_argument naming what was found and expected, if there is no pose, one is
/// not rigid, less than two lie within `own` and `reported`, or a keyframe moves farther than
/// max_motion_m; config::ConfigError.
OutsideCorrection computeOutsideCorrection(const Trajectory& own, const Trajectory& reported,
                                           const Trajectory& corrected, const std::string& frame,
                                           const OutsideCorrectionConfig& config = {});

/// ... of a jump of the map's frame: all that was seen moves alike.
/// @throws std::invalid_argument if there is no pose, or the motion is not rigid or moves the
/// camera farther than max_motion_m; config::ConfigError.
OutsideCorrection makeOutsideCorrection(const Trajectory& own, const Pose& T_new_old,
                                        const std::string& frame,
                                        const OutsideCorrectionConfig& config = {});

}  // namespace tsg::trajectory
