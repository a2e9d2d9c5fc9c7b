// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/region_layer.h"

#include <algorithm>
#include <limits>
#include <set>
#include <stdexcept>

#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/scene_graph/scoring.h"

namespace tsg::scene_graph {
namespace {

using bottleneck::IncrementalClustering;

bool isBefore(const Place* a, const Place* b) { return a->id < b->id; }

bool hasPlace(const std::vector<Place>& places, PlaceId id) {
  const auto found = std::lower_bound(places.begin(), places.end(), id,
                                      [](const Place& place, PlaceId x) { return place.id < x; });
  return found != places.end() && found->id == id;
}

/// Looks up an id in places sorted by id; null if it is not there.
const Place* findPlace(const std::vector<const Place*>& places, std::uint64_t id) {
  const auto found =
      std::lower_bound(places.begin(), places.end(), id,
                       [](const Place* place, std::uint64_t x) { return place->id.value < x; });
  return found != places.end() && (*found)->id.value == id ? *found : nullptr;
}

void checkPlaces(const PlaceGraph& graph) {
  PlaceId last;
  for (const auto& place : graph.places) {
    if (!(last < place.id)) {
      throw std::invalid_argument("place graph: id " + std::to_string(place.id.value) + " after " +
                                  std::to_string(last.value) + ", expected ascending ids from 1");
    }
    last = place.id;
  }
}

void checkEdges(const PlaceGraph& graph) {
  std::set<std::pair<PlaceId, PlaceId>> seen;
  for (const auto& edge : graph.edges) {
    const bool known = hasPlace(graph.places, edge.a) && hasPlace(graph.places, edge.b);
    if (known && edge.a < edge.b && seen.emplace(edge.a, edge.b).second) continue;
    throw std::invalid_argument(
        "place graph: edge " + std::to_string(edge.a.value) + " - " + std::to_string(edge.b.value) +
        ", expected two of its places, the smaller id first, each pair once");
  }
}

}  // namespace

RegionLayer::RegionLayer(const SceneGraphConfig& config)
    : config_(config),
      clustering_(std::make_unique<IncrementalClustering>(
          config.placeClustering(), IncrementalClustering::Adjacency::kGiven)),
      places_(std::make_shared<PlaceGraph>()) {}

RegionLayer::~RegionLayer() = default;

void RegionLayer::setTasks(const TaskList& tasks) {
  checkClusterable(tasks, "place tasks",
                   clustered_.empty() ? 0 : clustered_.front()->embedding.size());
  clustering_->setTasks(tasks.embeddings);
  scorer_ = bottleneck::TaskScorer(tasks.embeddings);
  tasks_ = tasks;
  apply(places_);  // embeddings that were of a wrong size may be of the right one now
}

void RegionLayer::setConfig(const SceneGraphConfig& config) {
  clustering_->setConfig(config.placeClustering());
  config_ = config;
}

PlaceUpdate RegionLayer::setPlaces(const PlaceGraphPtr& places) {
  if (!places) throw std::invalid_argument("place graph: null, expected a graph");
  checkPlaces(*places);
  checkEdges(*places);
  return apply(places);
}

/// Edges go first and come last, so that the clustering never sees one without its two places.
PlaceUpdate RegionLayer::apply(const PlaceGraphPtr& places) {
  PlaceUpdate update;
  const std::vector<const Place*> usable = findUsable(*places, update);
  std::vector<PlaceKeys> edges;
  for (const auto& edge : places->edges) {
    if (!findPlace(usable, edge.a.value) || !findPlace(usable, edge.b.value)) continue;
    edges.emplace_back(edge.a.value, edge.b.value);
  }
  std::sort(edges.begin(), edges.end());
  eraseEdges(edges, update);
  replacePlaces(usable, update);
  insertEdges(edges, update);
  clustered_ = usable;
  edges_ = edges;
  places_ = places;
  return update;
}

/// The places that can be clustered; the others are counted.
std::vector<const Place*> RegionLayer::findUsable(const PlaceGraph& graph,
                                                  PlaceUpdate& update) const {
  std::vector<const Place*> usable;
  Eigen::Index expected = tasks_.embeddings.cols();
  if (expected == 0 && !clustered_.empty()) expected = clustered_.front()->embedding.size();
  for (const auto& place : graph.places) {
    const Eigen::Index size = place.embedding.size();
    if (size > 0 && expected == 0) expected = size;
    if ((size > 0 && size != expected) || !place.embedding.allFinite()) {
      ++update.rejected;
      if (!update.error.empty()) continue;
      update.error = "place " + std::to_string(place.id.value) + " has an embedding of " +
                     std::to_string(size) + " values, expected " + std::to_string(expected) +
                     " finite ones";
    } else if (!hasDirection(place.embedding)) {
      ++update.without_embedding;
    } else {
      usable.push_back(&place);
    }
  }
  return usable;
}

void RegionLayer::replacePlaces(const std::vector<const Place*>& usable, PlaceUpdate& update) {
  for (const Place* place : clustered_) {
    if (std::binary_search(usable.begin(), usable.end(), place, isBefore)) continue;
    clustering_->erase(place->id.value);
    ++update.erased;
  }
  for (const Place* place : usable) {
    const Place* old = findPlace(clustered_, place->id.value);
    if (old == nullptr) {
      clustering_->insert(place->id.value, place->embedding);
      ++update.inserted;
    } else if (old->embedding != place->embedding) {
      clustering_->update(place->id.value, place->embedding);
      ++update.updated;
    }
  }
}

void RegionLayer::eraseEdges(const std::vector<PlaceKeys>& edges, PlaceUpdate& update) {
  for (const auto& edge : edges_) {
    if (std::binary_search(edges.begin(), edges.end(), edge)) continue;
    clustering_->eraseEdge(edge.first, edge.second);
    ++update.edges_erased;
  }
}

void RegionLayer::insertEdges(const std::vector<PlaceKeys>& edges, PlaceUpdate& update) {
  for (const auto& edge : edges) {
    if (std::binary_search(edges_.begin(), edges_.end(), edge)) continue;
    clustering_->insertEdge(edge.first, edge.second);
    ++update.edges_inserted;
  }
}

std::vector<Region> RegionLayer::computeRegions() {
  std::vector<Region> regions;
  for (const auto& cluster : clustering_->clusters()) {
    regions.push_back(makeRegion(cluster.members));
    regions.back().id = RegionId{cluster.id};
  }
  return regions;
}

Region RegionLayer::makeRegion(const std::vector<std::uint64_t>& members) const {
  Region region;
  EmbeddingMean embedding;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  for (const std::uint64_t key : members) {
    const Place& place = *findPlace(clustered_, key);
    region.places.push_back(place.id);
    embedding.add(place.embedding);
    mean_m += place.position_m / static_cast<double>(members.size());
  }
  double nearest_m2 = std::numeric_limits<double>::infinity();
  for (const std::uint64_t key : members) {
    const Eigen::Vector3d& position_m = findPlace(clustered_, key)->position_m;
    const double distance_m2 = (position_m - mean_m).squaredNorm();
    if (distance_m2 >= nearest_m2) continue;
    nearest_m2 = distance_m2;
    region.position_m = position_m;
  }
  region.embedding = embedding.mean();
  nameRegion(region);
  return region;
}

void RegionLayer::nameRegion(Region& region) const {
  const TaskScore best = findBestTask(region.embedding, scorer_);
  region.score = best.cosine;
  if (best.task_index < 0 || best.cosine < config_.place_alpha) return;
  region.task_index = best.task_index;
  region.task = tasks_.names[static_cast<std::size_t>(best.task_index)];
}

CosineSummary RegionLayer::summarizeCosines() const {
  std::vector<const Embedding*> embeddings;
  for (const Place& place : places_->places) embeddings.push_back(&place.embedding);
  return scene_graph::summarizeCosines(embeddings, scorer_);
}

}  // namespace tsg::scene_graph
