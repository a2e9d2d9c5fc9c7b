// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/object_layer.h"

#include <algorithm>

#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/scene_graph/scoring.h"

namespace tsg::scene_graph {
namespace {

using bottleneck::IncrementalClustering;

constexpr int kNullTask = 0;  // of bottleneck::Cluster::task

std::string describe(const ObjectPrimitive& primitive) {
  return "primitive " + std::to_string(primitive.id.value);
}

OrientedBox findOrientedBox(const ObjectPrimitive& primitive) {
  return primitive.oriented_box.isEmpty() ? toOrientedBox(primitive.box) : primitive.oriented_box;
}

bool isUsableBox(const Aabb& box) {
  return !box.isEmpty() && box.min().allFinite() && box.max().allFinite();
}

}  // namespace

PrimitiveCounters& PrimitiveCounters::operator+=(const PrimitiveCounters& other) {
  clustered += other.clustered;
  without_embedding += other.without_embedding;
  repeated += other.repeated;
  rejected += other.rejected;
  return *this;
}

ObjectLayer::ObjectLayer(const SceneGraphConfig& config)
    : config_(config),
      clustering_(std::make_unique<IncrementalClustering>(
          config.objectClustering(), IncrementalClustering::Adjacency::kBoxOverlap)) {}

ObjectLayer::~ObjectLayer() = default;

void ObjectLayer::setTasks(const TaskList& tasks) {
  checkClusterable(tasks, "object tasks", embedding_size_);
  clustering_->setTasks(tasks.embeddings);
  scorer_ = bottleneck::TaskScorer(tasks.embeddings);
  tasks_ = tasks;
  are_scores_stale_ = true;
}

void ObjectLayer::setConfig(const SceneGraphConfig& config) {
  clustering_->setConfig(config.objectClustering());
  are_scores_stale_ |= config.publishedFrom() != config_.publishedFrom();
  config_ = config;
}

PrimitiveUpdate ObjectLayer::add(const std::vector<ObjectPrimitivePtr>& primitives) {
  PrimitiveUpdate update;
  for (const auto& primitive : primitives) addOne(primitive, update);
  counters_ += update.counters;
  return update;
}

void ObjectLayer::addOne(const ObjectPrimitivePtr& primitive, PrimitiveUpdate& update) {
  const std::string fault = primitive ? findFault(*primitive) : "a primitive is null";
  if (!fault.empty()) {
    ++update.counters.rejected;
    if (update.error.empty()) update.error = fault;
    return;
  }
  if (!primitives_.emplace(primitive->id.value, primitive).second) {
    ++update.counters.repeated;
    return;
  }
  newest_ = std::max(newest_, primitive->last_seen);
  if (!hasDirection(primitive->embedding)) {
    ++update.counters.without_embedding;
    return;
  }
  embedding_size_ = primitive->embedding.size();
  clustering_->insert(primitive->id.value, primitive->embedding, primitive->box);
  ++update.counters.clustered;
}

std::string ObjectLayer::findFault(const ObjectPrimitive& primitive) const {
  if (!primitive.id.isValid()) return "a primitive has id 0, expected ids from 1";
  if (!isUsableBox(primitive.box)) {
    return describe(primitive) + " has a bounding box that is empty or not finite";
  }
  const Embedding& embedding = primitive.embedding;
  if (!embedding.allFinite()) {
    return describe(primitive) + " has an embedding with a NaN or infinite value";
  }
  const Eigen::Index expected = embedding_size_ > 0 ? embedding_size_ : tasks_.embeddings.cols();
  if (embedding.size() == 0 || expected == 0 || embedding.size() == expected) return "";
  return describe(primitive) + " has an embedding of " + std::to_string(embedding.size()) +
         " values, expected " + std::to_string(expected) + " as the " +
         (embedding_size_ > 0 ? "primitives before" : "object tasks") + " have";
}

std::vector<SceneObject> ObjectLayer::computeObjects() {
  const bottleneck::ClusteringUpdate update = clustering_->applyChanges();
  for (const std::uint64_t id : update.removed) objects_.erase(id);
  if (are_scores_stale_) {
    for (const auto& cluster : clustering_->clusters()) updateObject(cluster);
    are_scores_stale_ = false;
  } else {
    for (const auto& cluster : update.changed) updateObject(cluster);
  }
  std::vector<SceneObject> objects;
  objects.reserve(objects_.size());
  for (const auto& entry : objects_) objects.push_back(entry.second);
  return objects;
}

void ObjectLayer::updateObject(const bottleneck::Cluster& cluster) {
  objects_.erase(cluster.id);
  if (cluster.task == kNullTask) return;
  SceneObject object = makeObject(cluster.members);
  if (object.task_index < 0 || object.score < config_.publishedFrom()) return;
  object.id = ObjectId{cluster.id};
  objects_.emplace(cluster.id, std::move(object));
}

SceneObject ObjectLayer::makeObject(const std::vector<std::uint64_t>& members) const {
  SceneObject object;
  EmbeddingMean mean;
  std::vector<Eigen::Vector3f> corners_m;
  const ObjectPrimitive& first = *primitives_.at(members.front());
  object.first_seen = first.first_seen;
  object.last_seen = first.last_seen;
  for (const std::uint64_t key : members) {
    const ObjectPrimitive& primitive = *primitives_.at(key);
    object.primitives.push_back(primitive.id);
    object.box.extend(primitive.box);
    const auto box_corners_m = findOrientedBox(primitive).corners();
    corners_m.insert(corners_m.end(), box_corners_m.begin(), box_corners_m.end());
    object.position_m += primitive.box.center() / static_cast<double>(members.size());
    object.first_seen = std::min(object.first_seen, primitive.first_seen);
    object.last_seen = std::max(object.last_seen, primitive.last_seen);
    mean.add(primitive.embedding);
  }
  object.oriented_box = computeOrientedBox(corners_m);
  object.embedding = mean.mean();
  const TaskScore best = findBestTask(object.embedding, scorer_);
  object.task_index = best.task_index;
  object.score = best.cosine;
  if (best.task_index >= 0) object.task = tasks_.names[static_cast<std::size_t>(best.task_index)];
  return object;
}

std::vector<ObjectPrimitivePtr> ObjectLayer::primitives() const {
  std::vector<ObjectPrimitivePtr> list;
  list.reserve(primitives_.size());
  for (const auto& entry : primitives_) list.push_back(entry.second);
  return list;
}

CosineSummary ObjectLayer::summarizeCosines() const {
  std::vector<const Embedding*> embeddings;
  for (const auto& entry : primitives_) embeddings.push_back(&entry.second->embedding);
  return scene_graph::summarizeCosines(embeddings, scorer_);
}

}  // namespace tsg::scene_graph
