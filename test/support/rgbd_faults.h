// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "rgbd_walks.h"

/// Ways in which RGB-D input goes wrong.
namespace tsg::test {

/// Poses as world to camera.
RgbdWalk withInversePoses(RgbdWalk walk);
/// Poses of a frame whose axes are the columns of `R_optical_frame`, seen from the optical frame.
RgbdWalk withFrame(RgbdWalk walk, const Eigen::Matrix3d& R_optical_frame);
RgbdWalk withOpenglAxes(RgbdWalk walk);
RgbdWalk withBodyAxes(RgbdWalk walk);  ///< x forward, z up
RgbdWalk withMirroredWorld(RgbdWalk walk);
RgbdWalk withTranslationsTimes(RgbdWalk walk, double factor);
/// Depth read with `factor` times its true unit.
RgbdWalk withDepthTimes(RgbdWalk walk, double factor);
RgbdWalk withFocalLengthTimes(RgbdWalk walk, double factor);
RgbdWalk withRayDistances(RgbdWalk walk);
/// Depth as a camera `baseline_m` to the right of the colour camera sees it.
RgbdWalk withUnregisteredDepth(RgbdWalk walk, double baseline_m);
/// Each image gets the pose of `num_frames` images before.
RgbdWalk withLatePoses(const RgbdWalk& walk, int num_frames);
/// Gaussian noise of its own in every pose: `sigma_m` per axis, sigma_m / 2 radians.
RgbdWalk withPoseNoise(RgbdWalk walk, double sigma_m, unsigned seed);
/// Every depth image is the first one.
RgbdWalk withFrozenDepth(RgbdWalk walk);
RgbdWalk withConstantPose(RgbdWalk walk);
RgbdWalk withConstantDepth(RgbdWalk walk, float z_m);
RgbdWalk withoutMostDepth(RgbdWalk walk);
RgbdWalk withBlackColor(RgbdWalk walk);
/// A body before the camera that covers `share` of the image and moves to and fro.
RgbdWalk withPerson(RgbdWalk walk, double share);
/// The world turned, so that its z axis no longer is up.
RgbdWalk inWorld(RgbdWalk walk, const Eigen::Matrix3d& R_new_world);

}  // namespace tsg::test
