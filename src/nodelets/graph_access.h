// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "task_scene_graph/scene_graph/builder.h"

namespace tsg::nodelets {

/// What the services of the scene graph stage need of it. From any thread.
struct GraphAccess {
  using Job = std::function<void(scene_graph::SceneGraphBuilder&)>;

  /// The newest graph; null before the first.
  std::function<scene_graph::SceneGraphPtr()> graph;
  /// Runs a job in the builder's own thread, after what was queued before, and waits until the
  /// graph that follows from it is published. Throws what the job throws; std::runtime_error if the
  /// stage ends or takes longer than a minute.
  std::function<void(const Job&)> run;
  /// Full names of the services of this name that the stages before this one have.
  std::function<std::vector<std::string>(const std::string& name)> upstream_services;
  /// The mesh's vertices, given the object of each primitive; null where a stage before this one
  /// has the mesh.
  std::function<sensor_msgs::PointCloud2(const std::map<PrimitiveId, std::int32_t>&)> mesh_points{};
};

}  // namespace tsg::nodelets
