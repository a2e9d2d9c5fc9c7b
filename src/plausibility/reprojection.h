// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "depth_grid.h"

namespace tsg::plausibility {

/// A way of reading the input that may be right where the given one is wrong.
struct Hypothesis {
  enum class Kind {
    kGiven,
    kStandstill,   ///< no motion between the frames, whatever the poses say
    kInverse,      ///< poses map world to camera
    kAxes,         ///< the pose is of a frame with other axes than the optical ones
    kInverseAxes,  ///< both
    kTilted,       ///< the camera is mounted with another pitch than the pose says
    kMirrored,     ///< the world of the poses is left-handed
    kDepthScale,
    kFocalLength,
    kRayDistance,  ///< depth is the distance from the camera, not along the optical axis
    kDelay         ///< poses are those of another time
  };
  Kind kind = Kind::kGiven;
  /// Axes of the true optical frame in the given one; determinant -1 for kMirrored.
  Eigen::Matrix3d R_given_true = Eigen::Matrix3d::Identity();
  bool is_inverse = false;
  double depth_factor = 1.0;  ///< true depth / given depth
  double focal_factor = 1.0;  ///< true focal length / given focal length
  double delay_s = 0.0;       ///< the pose that belongs to an image is the one given so much later
};

/// Motion of the camera between two images, as the hypothesis reads the poses given for them.
Pose computeRelativePose(const Hypothesis& hypothesis, const Pose& T_world_target,
                         const Pose& T_world_source);

/// How far two depth images disagree when one is reprojected into the other.
struct Disagreement {
  double cost = 1.0;          ///< in [0, 1]; points that leave the image count 1/2
  double in_view_cost = 1.0;  ///< in [0, 1]; of the points that stay in the image
  double in_view_share = 0.0;
  std::size_t num_points = 0;  ///< compared, or out of the image
};

/// Moves each source point to the target's camera and compares its depth z with the four readings
/// round its pixel, of which the interval is [a, b]:
///   r = max(0, a - z, z - b) / z,   cost = min(1, (r / 0.045)^2)
/// so 1.5 % of the depth costs a ninth and 4.5 % or more costs 1. Points that fall on an invalid
/// reading are left out. A uniform scale of depth and translation changes nothing. O(points).
Disagreement computeDisagreement(const Hypothesis& hypothesis,
                                 const std::vector<PixelDepth>& source, const DepthGrid& target,
                                 const Pose& T_target_source);

/// Share of the points that the target shows at the same pixel with exactly the same depth.
double computeUnchangedShare(const std::vector<PixelDepth>& source, const DepthGrid& target);

/// Every single way of reading the input that is tried, the given one first and kStandstill second:
/// inverse poses, the 23 other ways to lay the axes (each also with inverse poses), mirrored
/// worlds, factors of depth and of the focal length, delays.
std::vector<Hypothesis> makeSingleHypotheses();

/// Pairs of these: (inverse or not) x (optical, OpenGL, body axes) x factors of depth.
std::vector<Hypothesis> makeDoubleHypotheses();

/// x right, y up, z backward, as graphics programs have it.
Eigen::Matrix3d openglAxes();
/// x forward, y left, z up, as robots have it (REP 103).
Eigen::Matrix3d bodyAxes();

}  // namespace tsg::plausibility
