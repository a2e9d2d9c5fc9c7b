// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/region_layer.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <stdexcept>

#include "place_features.h"
#include "place_index.h"
#include "region_embedding.h"
#include "region_groups.h"
#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/find_by_id.h"
#include "task_scene_graph/scene_graph/clusters.h"
#include "task_scene_graph/scene_graph/explanations.h"
#include "task_scene_graph/scene_graph/geometric_rooms.h"
#include "task_scene_graph/scene_graph/scoring.h"

namespace tsg::scene_graph {
namespace {

using bottleneck::IncrementalClustering;

const ClusterWords kWords{"place", "region"};

using PlaceKeys = std::pair<std::uint64_t, std::uint64_t>;

/// The entry of a key in members sorted by key; null if it is not there.
template <typename Member>
const Member* findMember(const std::vector<Member>& members, std::uint64_t key) {
  const auto found = findById(members, key, [](const Member& member) { return member.key; });
  return found != members.end() ? &*found : nullptr;
}

/// The same for keys that ascend from call to call. O(members) altogether.
template <typename Member>
class MembersInOrder {
 public:
  explicit MembersInOrder(const std::vector<Member>& members)
      : next_(members.begin()), end_(members.end()) {}

  const Member* find(std::uint64_t key) {
    while (next_ != end_ && next_->key < key) ++next_;
    return next_ != end_ && next_->key == key ? &*next_ : nullptr;
  }

 private:
  typename std::vector<Member>::const_iterator next_;
  typename std::vector<Member>::const_iterator end_;
};

/// Whether clusters that share no task are never merged: with one task for each place and a
/// threshold of at most a bit, for D / 2 of two such clusters is at least one.
bool keepsTasksApart(const bottleneck::ClusteringConfig& config) {
  return config.top_k == 1 && config.normaliser == bottleneck::Normaliser::kSizeInvariant &&
         config.delta_bits < 1.0;
}

std::uint32_t findTask(const bottleneck::SparseMasses& relevance) {
  const auto isLess = [](const bottleneck::TaskMass& a, const bottleneck::TaskMass& b) {
    return a.mass < b.mass;
  };
  return std::max_element(relevance.begin(), relevance.end(), isLess)->task;
}

std::string quoteTask(std::uint32_t task, const std::vector<std::string>& names) {
  return task == 0 ? "no task" : "'" + names[task - 1] + "'";
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
  const PlaceIndex index(graph);
  std::vector<PlaceKeys> keys;
  keys.reserve(graph.edges.size());
  for (const auto& edge : graph.edges) keys.emplace_back(edge.a.value, edge.b.value);
  if (!std::is_sorted(keys.begin(), keys.end())) std::sort(keys.begin(), keys.end());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto [a, b] = keys[i];
    const bool is_known =
        index.find({a}) != PlaceIndex::kNone && index.find({b}) != PlaceIndex::kNone;
    const bool is_new = i == 0 || keys[i - 1] != keys[i];
    if (is_known && a < b && is_new) continue;
    throw std::invalid_argument(
        "place graph: edge " + std::to_string(a) + " - " + std::to_string(b) +
        ", expected two of its places, the smaller id first, each pair once");
  }
}

/// What is in `a` and not in `b`; both in order.
std::vector<PlaceKeys> findMissing(const std::vector<PlaceKeys>& a,
                                   const std::vector<PlaceKeys>& b) {
  std::vector<PlaceKeys> missing;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(missing));
  return missing;
}

}  // namespace

void checkPlaceGraph(const PlaceGraph& graph) {
  checkPlaces(graph);
  checkEdges(graph);
}

struct RegionLayer::Description {
  Region region;
  RegionEmbedding embedding;
};

RegionLayer::RegionLayer(const SceneGraphConfig& config)
    : config_(config),
      clustering_(std::make_unique<IncrementalClustering>(
          config.placeClustering(), IncrementalClustering::Adjacency::kGiven)),
      places_(std::make_shared<PlaceGraph>()),
      features_(std::make_unique<PlaceFeatures>()),
      ids_(std::make_unique<RegionIds>()) {}

RegionLayer::~RegionLayer() = default;

void RegionLayer::setTasks(const TaskList& tasks) {
  const auto& features = features_->features();
  checkClusterable(tasks, "place tasks", features.empty() ? 0 : features.front().feature.size());
  clustering_->setTasks(tasks.embeddings);
  scorer_ = bottleneck::TaskScorer(tasks.embeddings);
  tasks_ = tasks;
  are_tasks_new_ = true;
  descriptions_.clear();
  apply(places_);  // embeddings that were of a wrong size may be of the right one now
}

void RegionLayer::setConfig(const SceneGraphConfig& config) {
  clustering_->setConfig(config.placeClustering());
  config_ = config;
  are_tasks_new_ = true;
  descriptions_.clear();
  apply(places_);
}

PlaceUpdate RegionLayer::setPlaces(const PlaceGraphPtr& places) {
  if (!places) throw std::invalid_argument("place graph: null, expected a graph");
  checkPlaceGraph(*places);
  return apply(places);
}

/// Edges go first and come last, so that the clustering never sees one without its two places.
PlaceUpdate RegionLayer::apply(const PlaceGraphPtr& places) {
  PlaceUpdate update;
  Eigen::Index size = tasks_.embeddings.cols();
  if (size == 0 && !members_.empty()) size = features_->features().front().feature.size();
  const UnusablePlaces unusable = features_->update(places, size, config_.place_smoothing_per_m);
  changed_places_.insert(features_->changed().begin(), features_->changed().end());
  update.rejected = unusable.rejected;
  update.error = unusable.error;
  update.without_embedding =
      places->places.size() - features_->features().size() - unusable.rejected;
  places_ = places;
  const std::vector<Member> members = makeMembers(are_tasks_new_);
  const std::vector<PlaceKeys> edges = listEdges(members);
  eraseEdges(edges, update);
  replaceMembers(members, update);
  insertEdges(edges, update);
  members_ = members;
  edges_ = edges;
  are_tasks_new_ = false;
  are_clusters_stale_ = true;
  return update;
}

std::vector<RegionLayer::Member> RegionLayer::makeMembers(bool are_tasks_new) const {
  const auto config = config_.placeClustering();
  std::vector<Member> members;
  members.reserve(features_->features().size());
  MembersInOrder<Member> former(members_);
  for (const PlaceFeature& found : features_->features()) {
    Member member{found.place->id.value, found.version, 0};
    const Member* old = former.find(member.key);
    if (old != nullptr && old->feature_version == found.version && !are_tasks_new) {
      member.task = old->task;
    } else if (keepsTasksApart(config)) {
      const auto scores = scorer_.computeScores(found.feature);
      member.task = findTask(bottleneck::computeRelevance(scores, config));
    }
    members.push_back(member);
  }
  return members;
}

/// Those that merges may follow, ascending. Edges between places of different tasks are left out
/// where such merges are never accepted: the components that a change touches are rooms then.
std::vector<RegionLayer::PlaceKeys> RegionLayer::listEdges(
    const std::vector<Member>& members) const {
  const PlaceIndex& index = features_->index();
  std::vector<const Member*> member_of(places_->places.size(), nullptr);
  for (const Member& member : members) member_of[index.find({member.key})] = &member;
  std::vector<PlaceKeys> edges;
  edges.reserve(places_->edges.size());
  for (const PlaceEdge& edge : places_->edges) {
    const Member* a = member_of[index.find(edge.a)];
    const Member* b = member_of[index.find(edge.b)];
    if (a == nullptr || b == nullptr || a->task != b->task) continue;
    edges.emplace_back(edge.a.value, edge.b.value);
  }
  if (!std::is_sorted(edges.begin(), edges.end())) std::sort(edges.begin(), edges.end());
  return edges;
}

void RegionLayer::replaceMembers(const std::vector<Member>& members, PlaceUpdate& update) {
  MembersInOrder<Member> present(members);
  for (const Member& member : members_) {
    if (present.find(member.key) != nullptr) continue;
    clustering_->erase(member.key);
    ++update.erased;
  }
  auto feature = features_->features().begin();
  MembersInOrder<Member> former(members_);
  for (const Member& member : members) {
    const Member* old = former.find(member.key);
    if (old == nullptr) {
      clustering_->insert(member.key, feature->feature);
      ++update.inserted;
    } else if (old->feature_version != member.feature_version) {
      clustering_->update(member.key, feature->feature);
      ++update.updated;
    }
    ++feature;
  }
}

void RegionLayer::eraseEdges(const std::vector<PlaceKeys>& edges, PlaceUpdate& update) {
  for (const auto& edge : findMissing(edges_, edges)) {
    clustering_->eraseEdge(edge.first, edge.second);
    ++update.edges_erased;
  }
}

void RegionLayer::insertEdges(const std::vector<PlaceKeys>& edges, PlaceUpdate& update) {
  for (const auto& edge : findMissing(edges, edges_)) {
    clustering_->insertEdge(edge.first, edge.second);
    ++update.edges_inserted;
  }
}

void RegionLayer::adoptIds(const std::vector<RegionCluster>& clusters) {
  std::map<RegionId, std::vector<PlaceId>> places_of;
  for (const RegionCluster& cluster : clusters) places_of[cluster.id] = cluster.places;
  ids_->adopt(places_of);
  are_clusters_stale_ = true;
}

void RegionLayer::updateClusters() {
  if (!are_clusters_stale_) return;
  PlaceGroups groups;
  if (config_.region_method == RegionMethod::kGeometric) {
    groups = computeGeometricRooms(*places_, config_.rooms);
  } else {
    for (const auto& cluster : clustering_->clusters()) {
      groups.emplace_back();
      for (const std::uint64_t key : cluster.members) groups.back().push_back(PlaceId{key});
    }
    groups = absorbSmallGroups(std::move(groups), places_->edges,
                               static_cast<std::size_t>(config_.min_region_places));
  }
  const std::vector<RegionId> ids = ids_->match(groups);
  clusters_.clear();
  for (std::size_t i = 0; i < groups.size(); ++i) {
    clusters_.push_back({ids[i], std::move(groups[i])});
  }
  std::sort(clusters_.begin(), clusters_.end(),
            [](const RegionCluster& a, const RegionCluster& b) { return a.id < b.id; });
  are_clusters_stale_ = false;
}

std::vector<Region> RegionLayer::computeRegions() {
  updateClusters();
  RegionEmbedding::BlockSet changed_blocks;
  for (const PlaceId id : changed_places_) changed_blocks.insert(RegionEmbedding::blockOf(id));
  const auto isChanged = [&](PlaceId id) { return changed_places_.count(id) > 0; };
  std::map<RegionId, std::unique_ptr<Description>> descriptions;
  std::vector<Region> regions;
  for (const auto& cluster : clusters_) {
    auto& description = descriptions[cluster.id] = std::move(descriptions_[cluster.id]);
    const bool is_same = description != nullptr && description->region.places == cluster.places &&
                         std::none_of(cluster.places.begin(), cluster.places.end(), isChanged);
    if (description == nullptr) description = std::make_unique<Description>();
    if (!is_same) describe(cluster, changed_blocks, *description);
    regions.push_back(description->region);
  }
  descriptions_ = std::move(descriptions);
  changed_places_.clear();
  return regions;
}

void RegionLayer::describe(const RegionCluster& cluster, const RegionEmbedding::BlockSet& changed,
                           Description& description) const {
  std::vector<const Place*> places;
  for (const PlaceId id : cluster.places) {
    places.push_back(&places_->places[features_->index().find(id)]);
  }
  Embedding mean = description.embedding.update(places, scorer_.dimension(), changed);
  description.region =
      describeRegion(places, std::move(mean), scorer_, tasks_.names, config_.place_alpha);
  description.region.id = cluster.id;
}

std::vector<RegionCluster> RegionLayer::computeClusters() {
  updateClusters();
  return clusters_;
}

void RegionLayer::setMergeLosses(const std::vector<RegionCluster>& regions,
                                 std::vector<RegionEdge>& edges) {
  if (config_.region_method == RegionMethod::kGeometric) return;
  struct Mass {
    bottleneck::SparseMasses tasks;
    double count = 0.0;
  };
  std::map<RegionId, Mass> masses;  // of the regions that have an edge
  for (const RegionEdge& edge : edges) {
    masses.try_emplace(edge.a);
    masses.try_emplace(edge.b);
  }
  for (const RegionCluster& region : regions) {
    const auto mass = masses.find(region.id);
    if (mass == masses.end()) continue;
    std::vector<bottleneck::NodeKey> keys;
    for (const PlaceId place : region.places) keys.push_back(place.value);
    const auto [tasks, count] = clustering_->sumRelevance(keys);
    mass->second = {tasks, static_cast<double>(count)};
  }
  const auto clustering = config_.placeClustering();
  const bool is_share = clustering.normaliser == bottleneck::Normaliser::kPaper;
  const double unit_bits =
      is_share ? static_cast<double>(clustering_->size()) * clustering_->information() : 2.0;
  for (RegionEdge& edge : edges) {
    const Mass& a = masses[edge.a];
    const Mass& b = masses[edge.b];
    const double cost_bits = bottleneck::computeMergeCost(a.tasks, a.count, b.tasks, b.count);
    edge.merge_loss = unit_bits > 0.0 ? cost_bits / unit_bits : 0.0;
    edge.merge_threshold = clustering.threshold();
  }
}

std::string RegionLayer::explainRegion(RegionId id) {
  updateClusters();
  const auto region = std::find_if(clusters_.begin(), clusters_.end(),
                                   [&](const RegionCluster& cluster) { return cluster.id == id; });
  const std::string name = "region " + std::to_string(id.value);
  if (region == clusters_.end()) throw std::invalid_argument("no " + name + " is in the map");
  const std::string size = std::to_string(region->places.size());
  if (config_.region_method == RegionMethod::kGeometric) {
    return name + ": " + size + " places in one room by the shape of free space (region_method)";
  }
  std::map<std::uint64_t, std::size_t> parts;  // clusters and their sizes
  for (const PlaceId place : region->places) ++parts[clustering_->clusterOf(place.value)];
  const auto largest = std::max_element(
      parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  auto explanation = clustering_->explainCluster(largest->first);
  explanation.id = id.value;
  std::string text = describeExplanation(explanation, tasks_.names, kWords);
  if (parts.size() == 1) return text;
  return text + "\nsmall parts beside it joined it (min_region_places): " +
         std::to_string(region->places.size() - largest->second) + " of " + size + " places";
}

std::string RegionLayer::explainPair(PlaceId a, PlaceId b) {
  requireClustered(a);
  requireClustered(b);
  updateClusters();
  const RegionId region = findRegion(a);
  const bool is_one = region.isValid() && region == findRegion(b);
  const std::string are = "places " + std::to_string(a.value) + " and " + std::to_string(b.value) +
                          " are " + (is_one ? "in one region" : "apart");
  if (config_.region_method == RegionMethod::kGeometric) {
    return are + " by the shape of free space (region_method)";
  }
  if (is_one && clustering_->clusterOf(a.value) != clustering_->clusterOf(b.value)) {
    return are + ": a part of fewer than " + std::to_string(config_.min_region_places) +
           " places joined its neighbour (min_region_places)";
  }
  const std::uint32_t task_a = findMember(members_, a.value)->task;
  const std::uint32_t task_b = findMember(members_, b.value)->task;
  if (task_a != task_b) {
    return are + ": one serves " + quoteTask(task_a, tasks_.names) + ", the other " +
           quoteTask(task_b, tasks_.names) +
           "; to merge places that share no task loses at least 1 bit (place_delta_bits)";
  }
  return describeExplanation(clustering_->explainPair(a.value, b.value), a.value, b.value,
                             tasks_.names, kWords);
}

RegionId RegionLayer::findRegion(PlaceId place) const {
  for (const RegionCluster& cluster : clusters_) {
    if (std::binary_search(cluster.places.begin(), cluster.places.end(), place)) return cluster.id;
  }
  return {};
}

void RegionLayer::requireClustered(PlaceId id) const {
  const bool is_there = features_->index().find(id) != PlaceIndex::kNone;
  const bool is_by_shape = config_.region_method == RegionMethod::kGeometric;
  if (clustering_->contains(id.value) || (is_there && is_by_shape)) return;
  throw std::invalid_argument(
      "place " + std::to_string(id.value) +
      (is_there ? " has no embedding, so it is in no region" : " is not in the map"));
}

CosineSummary RegionLayer::summarizeCosines() const {
  std::vector<const Embedding*> embeddings;
  for (const Place& place : places_->places) embeddings.push_back(&*place.embedding);
  return scene_graph::summarizeCosines(embeddings, scorer_);
}

}  // namespace tsg::scene_graph
