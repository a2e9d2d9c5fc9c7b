// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "task_scene_graph/core/camera.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/simulation/apartment.h"

namespace tsg::simulation {

/// What an ideal camera sees. All images have the camera's size.
struct RenderedView {
  cv::Mat color;                 ///< CV_8UC3, RGB
  cv::Mat depth_m;               ///< CV_32FC1, along the optical axis, exact; 0 = nothing hit
  cv::Mat labels;                ///< CV_16UC1, instance id; 0 = structure
  cv::Mat parts;                 ///< CV_16UC1, part id; 0 = structure
  std::vector<int> room_pixels;  ///< entry i = pixels whose surface lies in room i; entry 0 = none
};

/// Casts one ray per pixel against the closed-form solids (four more for the colour of pixels at
/// edges). Each image tile holds the solids that can be seen in it, nearest first, so a ray tests
/// few of them. Light: a long lamp under the ceiling of each room, soft light from above, darkening
/// near walls and under furniture; no cast shadows. Results do not depend on `num_threads`.
/// Thread-safe.
class Renderer {
 public:
  /// The apartment must outlive the renderer.
  Renderer(const Apartment& apartment, int num_threads);

  /// O(pixels x solids per tile). @throws std::invalid_argument if the camera model is invalid.
  RenderedView render(const CameraModel& camera, const Pose& T_world_camera) const;

 private:
  void buildFloorShades();
  cv::Mat makeFloorShade(const cv::Size& cells, double floor_z_m) const;
  float computeFloorShade(const Eigen::Vector2d& p_m, int floor) const;
  Color shade(const Solid& solid, const Eigen::Vector3d& p_world, const Eigen::Vector3d& p_solid,
              const Eigen::Vector3d& normal_solid, int& room_id) const;

  const Apartment& apartment_;
  int num_threads_;
  /// One for each floor: CV_32FC1, 1 = open floor, less under and beside furniture.
  std::vector<cv::Mat> floor_shades_;
  Eigen::Vector2d floor_origin_m_ = Eigen::Vector2d::Zero();

  friend class TileRenderer;
};

}  // namespace tsg::simulation
