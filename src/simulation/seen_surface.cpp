// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/seen_surface.h"

#include <cmath>

#include "task_scene_graph/core/files.h"

namespace tsg::simulation {
namespace {

constexpr double kCell_m = 0.05;
constexpr int kStep_px = 4;
constexpr float kRange_m = 6.0F;
constexpr int kNone = -1;

int toCell(double value_m) { return static_cast<int>(std::floor(value_m / kCell_m)); }

/// The number of the task of each instance, by its id; entry 0 is structure.
std::vector<int> findTasks(const Apartment& world, const std::vector<TaskTruth>& tasks) {
  std::vector<int> found(world.instances.size() + 1, kNone);
  const auto set = [&](std::uint16_t instance, std::size_t task) {
    if (found[instance] == kNone) found[instance] = static_cast<int>(task);
  };
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    for (const std::uint16_t id : tasks[i].instances) set(id, i);
    for (const std::size_t group : tasks[i].groups) {
      for (const std::uint16_t id : world.groups[group].instances) set(id, i);
    }
  }
  return found;
}

}  // namespace

void SeenSurface::add(const RenderedView& view, const CameraModel& camera,
                      const Pose& T_world_camera) {
  for (int v = 0; v < view.depth_m.rows; v += kStep_px) {
    for (int u = 0; u < view.depth_m.cols; u += kStep_px) {
      const float depth_m = view.depth_m.at<float>(v, u);
      if (depth_m <= 0.0F || depth_m > kRange_m) continue;
      const Eigen::Vector3d p_m =
          T_world_camera * camera.unproject(u, v, static_cast<double>(depth_m));
      cells_.emplace(Cell{toCell(p_m.x()), toCell(p_m.y()), toCell(p_m.z())},
                     Point{p_m.cast<float>(), view.labels.at<std::uint16_t>(v, u)});
    }
  }
}

void SeenSurface::write(const std::filesystem::path& path, const Apartment& world,
                        const std::vector<TaskTruth>& tasks) const {
  const std::vector<int> task_of_instance = findTasks(world, tasks);
  writeFileAtomically(path, [&](std::ostream& out) {
    out << "ply\nformat ascii 1.0\nelement vertex " << cells_.size()
        << "\nproperty float x\nproperty float y\nproperty float z\nproperty int label\n"
           "end_header\n";
    for (const auto& [cell, point] : cells_) {
      out << point.p_m.x() << " " << point.p_m.y() << " " << point.p_m.z() << " "
          << task_of_instance.at(point.instance) << "\n";
    }
  });
}

}  // namespace tsg::simulation
