// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <tuple>
#include <vector>

#include "task_scene_graph/core/camera.h"
#include "task_scene_graph/simulation/ground_truth.h"
#include "task_scene_graph/simulation/renderer.h"

namespace tsg::simulation {

/// The surfaces that a walk shows, as points with the instance that each belongs to: the truth for
/// maps whose vertices have classes. One point for each cell of 5 cm.
class SeenSurface {
 public:
  /// Takes every fourth pixel of every fourth row up to 6 m. O(pixels log cells).
  void add(const RenderedView& view, const CameraModel& camera, const Pose& T_world_camera);

  /// ASCII PLY: x, y, z (float, metres, world frame), `int label`: the number of the first task
  /// that the instance, or the group it is in, serves; -1: none, or structure.
  /// @throws std::runtime_error if the file cannot be written.
  void write(const std::filesystem::path& path, const Apartment& world,
             const std::vector<TaskTruth>& tasks) const;

  std::size_t size() const { return cells_.size(); }

 private:
  struct Point {
    Eigen::Vector3f p_m;
    std::uint16_t instance = 0;
  };
  using Cell = std::tuple<int, int, int>;

  std::map<Cell, Point> cells_;  ///< by what was seen first
};

}  // namespace tsg::simulation
