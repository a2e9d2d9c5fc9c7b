// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/object_layer.h"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <utility>

#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/bottleneck/reach.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/scene_graph/explanations.h"

namespace tsg::scene_graph {
namespace {

using bottleneck::IncrementalClustering;

const ClusterWords kWords{"primitive", "object"};

std::string describe(const ObjectPrimitive& primitive) {
  return "primitive " + std::to_string(primitive.id.value);
}

bool isUsableBox(const Aabb& box) {
  return !box.isEmpty() && box.min().allFinite() && box.max().allFinite();
}

}  // namespace

PrimitiveCounters& PrimitiveCounters::operator+=(const PrimitiveCounters& other) {
  clustered += other.clustered;
  without_embedding += other.without_embedding;
  repeated += other.repeated;
  replaced += other.replaced;
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
  const bool reaches_elsewhere = config.object_reach != config_.object_reach;
  config_ = config;
  if (!reaches_elsewhere) return;
  for (const auto& [id, primitive] : primitives_) cluster(*primitive);
}

PrimitiveUpdate ObjectLayer::add(const std::vector<ObjectPrimitivePtr>& primitives,
                                 Repeated repeated) {
  PrimitiveUpdate update;
  for (const auto& primitive : primitives) addOne(primitive, repeated, update);
  counters_ += update.counters;
  return update;
}

void ObjectLayer::addOne(const ObjectPrimitivePtr& primitive, Repeated repeated,
                         PrimitiveUpdate& update) {
  const std::string fault = primitive ? findFault(*primitive) : "a primitive is null";
  if (!fault.empty()) {
    ++update.counters.rejected;
    if (update.error.empty()) update.error = fault;
    return;
  }
  ObjectPrimitivePtr& place = primitives_[primitive->id.value];
  if (place != nullptr && repeated == Repeated::kDrop && !place->is_provisional) {
    ++update.counters.repeated;
    return;
  }
  if (place != nullptr) ++update.counters.replaced;
  place = primitive;
  newest_ = std::max(newest_, primitive->last_seen);
  cluster(*primitive);
  ++(hasDirection(primitive->embedding) ? update.counters.clustered
                                        : update.counters.without_embedding);
}

void ObjectLayer::cluster(const ObjectPrimitive& primitive) {
  const std::uint64_t key = primitive.id.value;
  const bool is_clustered = clustering_->contains(key);
  if (hasDirection(primitive.embedding)) {
    embedding_size_ = primitive.embedding.size();
    const Aabb box = bottleneck::extendUpAndDown(primitive.box, config_.object_reach);
    // Shared with the primitive, not copied.
    std::shared_ptr<const Embedding> embedding(primitives_.at(key), &primitive.embedding);
    if (is_clustered) {
      clustering_->update(key, std::move(embedding), box);
    } else {
      clustering_->insert(key, std::move(embedding), box);
    }
  } else if (is_clustered) {
    clustering_->erase(key);
  }
}

std::size_t ObjectLayer::erase(const std::vector<PrimitiveId>& ids) {
  std::size_t num_erased = 0;
  for (const PrimitiveId id : ids) {
    num_erased += primitives_.erase(id.value);
    if (clustering_->contains(id.value)) clustering_->erase(id.value);
  }
  if (clustering_->size() == 0) embedding_size_ = 0;
  newest_ = {};
  for (const auto& entry : primitives_) newest_ = std::max(newest_, entry.second->last_seen);
  return num_erased;
}

void ObjectLayer::adoptIds(const std::vector<ObjectCluster>& clusters) {
  std::vector<std::pair<std::uint64_t, std::vector<std::uint64_t>>> keys_of;
  for (const ObjectCluster& cluster : clusters) {
    keys_of.push_back({cluster.id.value, {}});
    for (const PrimitiveId id : cluster.primitives) keys_of.back().second.push_back(id.value);
  }
  clustering_->adoptIds(keys_of);
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
  const bool are_all_stale = std::exchange(are_scores_stale_, false);
  for (const auto& cluster : are_all_stale ? clustering_->clusters() : update.changed) {
    updateObject(cluster);
  }
  std::vector<SceneObject> objects;
  objects.reserve(objects_.size());
  for (const auto& entry : objects_) objects.push_back(entry.second);
  return objects;
}

std::vector<ObjectCluster> ObjectLayer::computeClusters() {
  computeObjects();  // what has changed: clusters() forgets it
  std::vector<ObjectCluster> clusters;
  for (const auto& found : clustering_->clusters()) {
    clusters.push_back({{found.id}, found.task, {}});
    for (const std::uint64_t key : found.members) clusters.back().primitives.push_back({key});
  }
  return clusters;
}

void ObjectLayer::updateObject(const bottleneck::Cluster& cluster) {
  objects_.erase(cluster.id);
  if (cluster.task == 0) return;  // serves no task: not published, whatever it looks like
  SceneObject object = describeObject(findMembers(cluster.members), scorer_, tasks_.names);
  if (!isPublished(cluster.task, object, config_)) return;
  object.id = ObjectId{cluster.id};
  objects_.emplace(cluster.id, std::move(object));
}

std::vector<const ObjectPrimitive*> ObjectLayer::findMembers(
    const std::vector<std::uint64_t>& keys) const {
  std::vector<const ObjectPrimitive*> members;
  members.reserve(keys.size());
  for (const std::uint64_t key : keys) members.push_back(primitives_.at(key).get());
  return members;
}

std::string ObjectLayer::explainObject(ObjectId id) {
  computeObjects();  // what has changed: the explanation forgets it
  try {
    return describeExplanation(clustering_->explainCluster(id.value), tasks_.names, kWords);
  } catch (const std::out_of_range&) {
    throw std::invalid_argument("no object " + std::to_string(id.value) + " is in the map");
  }
}

std::string ObjectLayer::explainPrimitive(PrimitiveId id) {
  requireClustered(id);
  computeObjects();
  return describeExplanation(clustering_->explainPrimitive(id.value), tasks_.names, kWords);
}

std::string ObjectLayer::explainPair(PrimitiveId a, PrimitiveId b) {
  requireClustered(a);
  requireClustered(b);
  computeObjects();
  return describeExplanation(clustering_->explainPair(a.value, b.value), a.value, b.value,
                             tasks_.names, kWords);
}

void ObjectLayer::requireClustered(PrimitiveId id) const {
  if (clustering_->contains(id.value)) return;
  const bool is_known = primitives_.count(id.value) > 0;
  throw std::invalid_argument(
      "primitive " + std::to_string(id.value) +
      (is_known ? " has no embedding, so it is in no object" : " is not in the map"));
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
