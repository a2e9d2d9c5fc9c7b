// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/place_extractor.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <unordered_map>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/places/near_pairs.h"

namespace tsg::places {
namespace {

bool hasUsableDepth(const RgbdFrame& frame) {
  const int type = frame.depth.image.type();
  return (type == CV_16UC1 || type == CV_32FC1) &&
         frame.depth.image.cols == frame.camera.width_px &&
         frame.depth.image.rows == frame.camera.height_px;
}

bool isUsableEmbedding(const Embedding& embedding) {
  return embedding.size() > 0 && embedding.allFinite() && !embedding.isZero(0.0F);
}

PlaceEdge makeEdge(PlaceId a, PlaceId b, double clearance_m) {
  return a < b ? PlaceEdge{a, b, clearance_m} : PlaceEdge{b, a, clearance_m};
}

bool isBefore(const PlaceEdge& left, const PlaceEdge& right) {
  return left.a == right.a ? left.b < right.b : left.a < right.a;
}

/// Adds the cells of one floor.
void addFloor(const FreeSpace& space, double body_height_m, GroundPlan& plan) {
  std::map<GroundPlan::Index, std::shared_ptr<GroundPlan::Tile>> tiles;
  for (std::size_t i = 0; i < space.is_free.size(); ++i) {
    const bool is_obstacle = space.parent[i] == static_cast<std::int32_t>(i);
    if (space.is_free[i] == 0 && !is_obstacle) continue;
    const GridIndex at = space.extent.toIndex(i);
    auto& tile = tiles[computeTile({at.x(), at.y()})];
    if (!tile) tile = std::make_shared<GroundPlan::Tile>();
    PlanCell& cell = (*tile)[computeOffset({at.x(), at.y()})];
    cell.state = is_obstacle ? PlanCell::State::kObstacle : PlanCell::State::kFree;
    cell.floor_m = space.height_m[i] - static_cast<float>(body_height_m / 2.0);
    cell.clearance_m = space.clearance_m[i];
  }
  for (const auto& [index, tile] : tiles) {
    auto all = plan.tilesAt(index);
    all.push_back(tile);
    plan.setTiles(index, std::move(all));
  }
}

}  // namespace

PlaceExtractor::PlaceExtractor(const PlacesConfig& config)
    : config_((config::validate(config, "places"), config)),
      ground_(config),
      views_(config.max_views, config.max_view_range_m, config.occlusion_tolerance_m,
             config.view_weighting) {}

void PlaceExtractor::update(const mapping::TsdfVolume& free_space,
                            const std::vector<mapping::GridIndex>& changed_blocks, Stamp stamp) {
  const auto changed_columns = voxels_.copyBlocks(free_space, changed_blocks);
  ++counters_.updates;
  stamp_ = stamp;
  if (changed_columns.empty()) return;
  if (config_.free_space == FreeSpaceKind::kWalkable) {
    ground_.updateColumns(voxels_, changed_columns);
  }
  replacePlaces(computeSparseGraph());
}

void PlaceExtractor::addPose(const CameraPose&) {}

SparseGraph PlaceExtractor::computeSparseGraph() {
  const auto sparsify = [&](const FreeSpace& space) {
    return places::computeSparseGraph(space, findVoronoiCells(space, config_), config_);
  };
  SparseGraph graph;
  if (config_.free_space == FreeSpaceKind::kVolume) {
    // Obstacles beyond this are not looked for.
    const double block_m = voxels_.voxelSize() * mapping::kBlockSide;
    const int reach = 1 + static_cast<int>(std::ceil(config_.max_distance_m / block_m));
    for (const auto& island : splitIntoIslands(voxels_.columnIndices(), reach)) {
      graph.append(sparsify(makeVolumeSpace(voxels_, island, config_)));
    }
    return graph;
  }
  plan_ = GroundPlan(voxels_.voxelSize());
  for (const Floor& floor : ground_.computeFloors(voxels_.voxelSize())) {
    const FreeSpace space = makeWalkableSpace(voxels_, floor, config_);
    graph.append(sparsify(space));
    addFloor(space, config_.body_height_m, plan_);
  }
  return graph;
}

std::vector<PlaceId> PlaceExtractor::matchIds(const std::vector<SparsePlace>& found) {
  std::vector<Eigen::Vector3d> old_m;
  std::vector<Eigen::Vector3d> new_m;
  for (const PlaceState& state : places_) old_m.push_back(state.place.position_m);
  for (const SparsePlace& place : found) new_m.push_back(place.position_m);
  std::vector<PlaceId> ids(found.size());
  std::vector<char> is_taken(places_.size(), 0);
  for (const NearPair& pair : findNearPairs(old_m, new_m, config_.cell_size_m)) {
    if (is_taken[pair.a] != 0 || ids[pair.b].isValid()) continue;
    is_taken[pair.a] = 1;
    ids[pair.b] = places_[pair.a].place.id;
  }
  counters_.places_removed +=
      static_cast<std::uint64_t>(std::count(is_taken.begin(), is_taken.end(), 0));
  for (PlaceId& id : ids) {
    if (id.isValid()) continue;
    id = PlaceId{next_id_++};
    ++counters_.places_created;
  }
  return ids;
}

void PlaceExtractor::replacePlaces(const SparseGraph& sparse) {
  const std::vector<PlaceId> ids = matchIds(sparse.places);
  std::unordered_map<PlaceId, PlaceState*> old;
  for (PlaceState& state : places_) old[state.place.id] = &state;
  std::vector<PlaceState> places(sparse.places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const SparsePlace& found = sparse.places[i];
    places[i].place = {ids[i], found.position_m, found.clearance_m, {}, 0};
    const auto same = old.find(ids[i]);
    const bool has_stayed = same != old.end() && same->second->place.position_m == found.position_m;
    places[i].views =
        has_stayed ? std::move(same->second->views) : views_.collect(found.position_m);
  }
  std::sort(places.begin(), places.end(),
            [](const PlaceState& a, const PlaceState& b) { return a.place.id < b.place.id; });
  places_ = std::move(places);
  edges_.clear();
  for (const SparseEdge& edge : sparse.edges) {
    edges_.push_back(makeEdge(ids[edge.a], ids[edge.b], edge.clearance_m));
  }
  std::sort(edges_.begin(), edges_.end(), isBefore);
}

void PlaceExtractor::addView(const RgbdFrame& frame, const Embedding& image_embedding) {
  const bool fits = embedding_size_ == 0 || image_embedding.size() == embedding_size_;
  if (!fits || !isUsableEmbedding(image_embedding) || !hasUsableDepth(frame) ||
      !frame.T_world_camera.matrix().allFinite()) {
    ++counters_.ignored_views;
    return;
  }
  embedding_size_ = image_embedding.size();
  const View& view = views_.add(makeView(frame, image_embedding));
  for (PlaceState& state : places_) {
    views_.addTo(state.views, view, state.place.position_m);
  }
  ++counters_.views;
  counters_.forgotten_views = views_.numForgotten();
}

PlaceGraph PlaceExtractor::graph() const {
  PlaceGraph graph;
  graph.stamp = stamp_;
  graph.edges = edges_;
  for (const PlaceState& state : places_) {
    graph.places.push_back(state.place);
    graph.places.back().embedding = state.views.computeMean();
    graph.places.back().num_views = state.views.count;
  }
  return graph;
}

}  // namespace tsg::places
