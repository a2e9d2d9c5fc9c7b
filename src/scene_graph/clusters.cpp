// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/clusters.h"

#include <algorithm>
#include <utility>

#include "footprint.h"
#include "region_embedding.h"
#include "task_scene_graph/core/point_index.h"
#include "task_scene_graph/scene_graph/primitive_union.h"
#include "task_scene_graph/scene_graph/scoring.h"

namespace tsg::scene_graph {
namespace {

constexpr int kNullTask = 0;  // of ObjectCluster::task

OrientedBox findOrientedBox(const ObjectPrimitive& primitive) {
  return primitive.oriented_box.isEmpty() ? toOrientedBox(primitive.box) : primitive.oriented_box;
}

OrientedBox computeHull(const std::vector<const ObjectPrimitive*>& members) {
  std::vector<Eigen::Vector3f> corners_m;
  for (const ObjectPrimitive* primitive : members) {
    const auto box_corners_m = findOrientedBox(*primitive).corners();
    corners_m.insert(corners_m.end(), box_corners_m.begin(), box_corners_m.end());
  }
  return computeOrientedBox(corners_m);
}

const Place& findNearestToMean(const std::vector<const Place*>& places) {
  const auto count = static_cast<double>(places.size());
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  for (const Place* place : places) mean_m += place->position_m / count;
  const auto isNearer = [&](const Place* a, const Place* b) {
    return (a->position_m - mean_m).squaredNorm() < (b->position_m - mean_m).squaredNorm();
  };
  return **std::min_element(places.begin(), places.end(), isNearer);
}

}  // namespace

SceneObject describeObject(const std::vector<const ObjectPrimitive*>& members,
                           const bottleneck::TaskScorer& scorer,
                           const std::vector<std::string>& tasks) {
  SceneObject object;
  object.first_seen = members.front()->first_seen;
  object.last_seen = members.front()->last_seen;
  PrimitiveUnion whole;
  for (const ObjectPrimitive* primitive : members) {
    object.primitives.push_back(primitive->id);
    object.first_seen = std::min(object.first_seen, primitive->first_seen);
    object.last_seen = std::max(object.last_seen, primitive->last_seen);
    whole.add(primitive->box.center(), primitive->box, primitive->embedding);
  }
  object.box = whole.box();
  object.oriented_box = computeHull(members);
  object.position_m = whole.position_m();
  object.embedding = whole.embedding();
  const TaskScore best = findBestTask(object.embedding, scorer);
  object.task_index = best.task_index;
  object.score = best.cosine;
  if (best.task_index >= 0) object.task = tasks[static_cast<std::size_t>(best.task_index)];
  return object;
}

bool isPublished(int cluster_task, const SceneObject& object, const SceneGraphConfig& config) {
  return cluster_task != kNullTask && object.task_index >= 0 &&
         object.score >= config.publishedFrom();
}

Region describeRegion(const std::vector<const Place*>& members,
                      const bottleneck::TaskScorer& scorer, const std::vector<std::string>& tasks,
                      double place_alpha) {
  Embedding mean = RegionEmbedding().update(members, scorer.dimension(), {});
  return describeRegion(members, std::move(mean), scorer, tasks, place_alpha);
}

Region describeRegion(const std::vector<const Place*>& members, Embedding mean,
                      const bottleneck::TaskScorer& scorer, const std::vector<std::string>& tasks,
                      double place_alpha) {
  Region region;
  for (const Place* place : members) region.places.push_back(place->id);
  region.position_m = findNearestToMean(members).position_m;
  region.embedding = std::move(mean);
  Footprint footprint = computeFootprint(members);
  region.area_m2 = footprint.area_m2;
  region.footprint_m = std::move(footprint.outline_m);
  const TaskScore best = findBestTask(region.embedding, scorer);
  region.score = best.cosine;
  if (best.task_index < 0 || best.cosine < place_alpha) return region;
  region.task_index = best.task_index;
  region.task = tasks[static_cast<std::size_t>(best.task_index)];
  return region;
}

void setNearestPlaces(const PlaceGraph& places, std::vector<SceneObject>& objects) {
  if (objects.empty()) return;
  std::vector<Eigen::Vector3d> positions_m;
  for (const Place& place : places.places) positions_m.push_back(place.position_m);
  const PointIndex index(std::move(positions_m));
  for (SceneObject& object : objects) {
    object.place =
        index.isEmpty() ? PlaceId{} : places.places[index.findNearest(object.position_m)].id;
  }
}

}  // namespace tsg::scene_graph
