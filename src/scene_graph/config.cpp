// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/config.h"

namespace tsg::scene_graph {

bottleneck::ClusteringConfig SceneGraphConfig::objectClustering() const {
  bottleneck::ClusteringConfig clustering;
  clustering.alpha = object_alpha;
  clustering.delta = object_delta;
  clustering.top_k = object_top_k;
  clustering.prune_null = prune_null;
  clustering.prior = prior;
  clustering.normaliser = object_normaliser;
  clustering.delta_bits = object_delta_bits;
  clustering.num_threads = num_threads;
  return clustering;
}

bottleneck::ClusteringConfig SceneGraphConfig::placeClustering() const {
  bottleneck::ClusteringConfig clustering;
  clustering.alpha = place_alpha;
  clustering.delta = place_delta;
  clustering.top_k = place_top_k;
  clustering.prune_null = prune_null;
  clustering.prior = prior;
  clustering.normaliser = place_normaliser;
  clustering.delta_bits = place_delta_bits;
  clustering.num_threads = num_threads;
  return clustering;
}

}  // namespace tsg::scene_graph
