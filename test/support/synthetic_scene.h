// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "task_scene_graph/core/frame.h"

namespace tsg::test {

/// A solid with a closed form: where a ray first enters it, and how far a point is from it.
struct Solid {
  /// Smallest t > 0 with origin + t * direction on the surface; infinity if none.
  std::function<double(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)> hit;
  /// Distance to the surface, metres, negative inside.
  std::function<double(const Eigen::Vector3d& p)> distance_m;
  cv::Vec3b color_rgb;
  std::uint16_t label = 0;
};

/// Half-space below the plane through `point` with unit `normal` (pointing to free space).
Solid makePlane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, cv::Vec3b color_rgb);
Solid makeSphere(const Eigen::Vector3d& center, double radius_m, cv::Vec3b color_rgb,
                 std::uint16_t label = 0);
Solid makeBox(const Eigen::AlignedBox3d& box, cv::Vec3b color_rgb, std::uint16_t label = 0);

struct Rendering {
  RgbdFrame frame;  ///< depth CV_32FC1 metres, colour RGB
  cv::Mat labels;   ///< CV_16UC1
};

/// Casts one ray per pixel centre; 0 depth where nothing is hit.
Rendering render(const std::vector<Solid>& scene, const CameraModel& camera,
                 const Pose& T_world_camera);

/// Optical-frame pose at `eye` that looks at `target`, image up along +z of the world.
Pose lookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

/// Distance to the nearest solid of the scene, metres, negative inside.
double computeSceneDistance(const std::vector<Solid>& scene, const Eigen::Vector3d& p);

}  // namespace tsg::test
