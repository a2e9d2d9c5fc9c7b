// SPDX-License-Identifier: BSD-3-Clause
#include <iostream>

#include "task_scene_graph/bottleneck/clustering.h"

int main() {
  using Eigen::Vector3d, Eigen::Vector3f;
  tsg::bottleneck::ClusteringConfig config;
  config.delta = 0.3;  // the share of the information on the tasks that one merge may lose
  tsg::bottleneck::IncrementalClustering map(config, tsg::bottleneck::Adjacency::kBoxOverlap);
  tsg::EmbeddingMatrix tasks(2, 3);  // one row for each task
  tasks << 1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F;
  map.setTasks(tasks);

  const auto box = [](double x) { return tsg::Aabb(Vector3d(x, 0, 0), Vector3d(x + 1.0, 1, 1)); };
  map.insert(1, Vector3f(0.9F, 0.1F, 0.2F), box(0.0));  // metres, world frame
  map.insert(2, Vector3f(0.8F, 0.1F, 0.3F), box(0.5));  // overlaps 1, serves the same task
  map.insert(3, Vector3f(0.1F, 0.9F, 0.2F), box(1.2));  // overlaps 2, serves the other
  for (const auto& object : map.clusters()) {
    std::cout << object.members.size() << " primitives serve task " << object.task << "\n";
  }
  const auto why = map.explainPair(2, 3);
  std::cout << "joining 2 and 3 would lose " << why.merge->delta << " of the information\n";
}
