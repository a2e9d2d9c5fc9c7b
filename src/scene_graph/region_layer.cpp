// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/region_layer.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/scene_graph/clusters.h"
#include "task_scene_graph/scene_graph/explanations.h"
#include "task_scene_graph/scene_graph/scoring.h"

namespace tsg::scene_graph {
namespace {

using bottleneck::IncrementalClustering;

const ClusterWords kWords{"place", "region"};

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
    if (place.position_m.allFinite() && std::isfinite(place.clearance_m)) continue;
    throw std::invalid_argument("place graph: place " + std::to_string(place.id.value) +
                                " has a position or clearance that is not finite");
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
    std::vector<const Place*> members;
    for (const std::uint64_t key : cluster.members) members.push_back(findPlace(clustered_, key));
    regions.push_back(describeRegion(members, scorer_, tasks_.names, config_.place_alpha));
    regions.back().id = RegionId{cluster.id};
  }
  return regions;
}

std::vector<RegionCluster> RegionLayer::computeClusters() {
  std::vector<RegionCluster> clusters;
  for (const auto& found : clustering_->clusters()) {
    clusters.push_back({{found.id}, {}});
    for (const std::uint64_t key : found.members) clusters.back().places.push_back({key});
  }
  return clusters;
}

std::string RegionLayer::explainRegion(RegionId id) {
  try {
    return describeExplanation(clustering_->explainCluster(id.value), tasks_.names, kWords);
  } catch (const std::out_of_range&) {
    throw std::invalid_argument("no region " + std::to_string(id.value) + " is in the map");
  }
}

std::string RegionLayer::explainPair(PlaceId a, PlaceId b) {
  requireClustered(a);
  requireClustered(b);
  return describeExplanation(clustering_->explainPair(a.value, b.value), a.value, b.value,
                             tasks_.names, kWords);
}

void RegionLayer::requireClustered(PlaceId id) const {
  if (clustering_->contains(id.value)) return;
  throw std::invalid_argument("place " + std::to_string(id.value) +
                              (hasPlace(places_->places, id)
                                   ? " has no embedding, so it is in no region"
                                   : " is not in the map"));
}

CosineSummary RegionLayer::summarizeCosines() const {
  std::vector<const Embedding*> embeddings;
  for (const Place& place : places_->places) embeddings.push_back(&place.embedding);
  return scene_graph::summarizeCosines(embeddings, scorer_);
}

}  // namespace tsg::scene_graph
