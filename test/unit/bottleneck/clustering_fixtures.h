// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "bottleneck_reference.h"
#include "task_scene_graph/bottleneck/clustering.h"

namespace tsg::bottleneck {

using Partition = std::vector<std::vector<NodeKey>>;

inline IncrementalClustering makeClustering(const test::ReferenceScene& scene,
                                            const ClusteringConfig& config) {
  IncrementalClustering clustering(config, Adjacency::kBoxOverlap);
  clustering.setTasks(scene.tasks);
  for (const auto& [key, primitive] : scene.primitives) {
    clustering.insert(key, primitive.embedding, primitive.box);
  }
  return clustering;
}

inline Partition partitionOf(IncrementalClustering& clustering) {
  Partition partition;
  for (const Cluster& cluster : clustering.clusters()) partition.push_back(cluster.members);
  std::sort(partition.begin(), partition.end());
  return partition;
}

// Primitives whose scores are exactly the given ones: tasks are axes, one axis more fills up.
inline IncrementalClustering makeFromScores(const std::vector<std::vector<float>>& scores,
                                            const std::vector<test::KeyPair>& edges,
                                            const ClusteringConfig& config) {
  const auto num_tasks = static_cast<Eigen::Index>(scores[0].size());
  IncrementalClustering clustering(config, Adjacency::kGiven);
  clustering.setTasks(EmbeddingMatrix::Identity(num_tasks, num_tasks + 1));
  for (std::size_t i = 0; i < scores.size(); ++i) {
    Embedding x(num_tasks + 1);
    x.head(num_tasks) = Eigen::Map<const Eigen::VectorXf>(scores[i].data(), num_tasks);
    x[num_tasks] = std::sqrt(1.0f - x.head(num_tasks).squaredNorm());
    clustering.insert(i, x);
  }
  for (const auto& [a, b] : edges) clustering.insertEdge(a, b);
  return clustering;
}

inline ClusteringConfig makePublishedConfig(double alpha, int top_k, bool cumulative, bool prune) {
  ClusteringConfig config;
  config.alpha = alpha;
  config.top_k = top_k;
  config.cumulative = cumulative;
  config.prune_null = prune;
  return config;
}

}  // namespace tsg::bottleneck
