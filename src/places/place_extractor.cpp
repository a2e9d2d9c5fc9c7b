// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/place_extractor.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "place_layers.h"
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

bool isBefore(const PlaceEdge& left, const PlaceEdge& right) {
  return left.a == right.a ? left.b < right.b : left.a < right.a;
}

}  // namespace

void PlaceExtractor::PlaceState::setViews(ViewSum sum) {
  views_ = std::move(sum);
  place.embedding = views_.computeMean();
  place.num_views = views_.count;
}

void PlaceExtractor::PlaceState::addView(const ViewDatabase& database, const View& view) {
  if (database.addTo(views_, view, place.position_m)) setViews(std::move(views_));
}

PlaceExtractor::PlaceExtractor(const PlacesConfig& config)
    : config_((config::validate(config, "places"), config)),
      layers_(std::make_unique<PlaceLayers>(config)),
      views_(config.max_views, config.max_view_range_m, config.occlusion_tolerance_m,
             config.view_weighting) {}

PlaceExtractor::~PlaceExtractor() = default;
PlaceExtractor::PlaceExtractor(PlaceExtractor&&) = default;
PlaceExtractor& PlaceExtractor::operator=(PlaceExtractor&&) = default;

void PlaceExtractor::addPose(const CameraPose& pose) { layers_->addPose(pose); }

const GroundPlan& PlaceExtractor::plan() const { return layers_->plan(); }

void PlaceExtractor::update(const mapping::TsdfVolume& free_space,
                            const std::vector<mapping::GridIndex>& changed_blocks, Stamp stamp) {
  const auto changed = voxels_.copyBlocks(free_space, changed_blocks);
  ++counters_.updates;
  stamp_ = stamp;
  const CellSet cells = layers_->update(voxels_, {changed.begin(), changed.end()});
  const std::vector<GridIndex> touched(cells.begin(), cells.end());
  Changes changes = findChanges(touched);
  matchIds(changes);
  addPlaces(changes);
  updateEdges(touched);
}

/// Takes the places that are no longer there out of the graph.
PlaceExtractor::Changes PlaceExtractor::findChanges(const std::vector<GridIndex>& touched) {
  Changes changes;
  for (const GridIndex& key : touched) {
    const auto* node = layers_->links().find(key);
    const auto id = id_of_key_.find(key);
    const bool is_place = node != nullptr && node->is_kept;
    if (id == id_of_key_.end()) {
      if (!is_place) continue;
      changes.added.emplace_back();
      changes.added.back().key = key;
      changes.added.back().place.position_m = node->seed.position_m;
      changes.added.back().place.clearance_m = static_cast<double>(node->seed.clearance_m);
    } else if (is_place) {
      places_.at(id->second)->place.clearance_m = static_cast<double>(node->seed.clearance_m);
    } else {
      changes.removed.push_back(removePlace(id->second));
    }
  }
  return changes;
}

void PlaceExtractor::matchIds(Changes& changes) {
  std::vector<Eigen::Vector3d> old_m;
  std::vector<Eigen::Vector3d> new_m;
  for (const PlaceState& state : changes.removed) old_m.push_back(state.place.position_m);
  for (const PlaceState& state : changes.added) new_m.push_back(state.place.position_m);
  std::vector<char> is_taken(old_m.size(), 0);
  for (const NearPair& pair : findNearPairs(old_m, new_m, config_.cell_size_m)) {
    PlaceId& id = changes.added[pair.b].place.id;
    if (is_taken[pair.a] != 0 || id.isValid()) continue;
    is_taken[pair.a] = 1;
    id = changes.removed[pair.a].place.id;
  }
  counters_.places_removed +=
      static_cast<std::uint64_t>(std::count(is_taken.begin(), is_taken.end(), 0));
}

void PlaceExtractor::addPlaces(const Changes& changes) {
  for (const PlaceState& added : changes.added) {
    PlaceState state = added;
    if (!state.place.id.isValid()) {
      state.place.id = PlaceId{next_id_++};
      ++counters_.places_created;
    }
    state.setViews(views_.collect(state.place.position_m));
    insertPlace(std::move(state));
  }
}

void PlaceExtractor::insertPlace(PlaceState state) {
  const PlaceId id = state.place.id;
  id_of_key_[state.key] = id;
  cubes_[computeCube(state.place.position_m)].push_back(id);
  places_[id] = std::make_unique<PlaceState>(std::move(state));
}

PlaceExtractor::PlaceState PlaceExtractor::removePlace(PlaceId id) {
  const auto found = places_.find(id);
  PlaceState state = std::move(*found->second);
  places_.erase(found);
  id_of_key_.erase(state.key);
  const auto cube = cubes_.find(computeCube(state.place.position_m));
  std::vector<PlaceId>& ids = cube->second;
  ids.erase(std::find(ids.begin(), ids.end(), id));
  if (ids.empty()) cubes_.erase(cube);
  return state;
}

/// Cubes so large that a view reaches five of them at most in each direction.
GridIndex PlaceExtractor::computeCube(const Eigen::Vector3d& p_world) const {
  constexpr double kSmallest_m = 2.0;
  constexpr double kFarthest = 1e9;
  const double side_m = std::max(kSmallest_m, 0.5 * config_.max_view_range_m);
  return (p_world / side_m).array().floor().max(-kFarthest).min(kFarthest).cast<int>();
}

/// A place whose edges change is among those touched, at both ends.
void PlaceExtractor::updateEdges(const std::vector<GridIndex>& touched) {
  for (const GridIndex& key : touched) {
    const auto id = id_of_key_.find(key);
    if (id == id_of_key_.end()) continue;
    std::vector<PlaceEdge>& edges = places_.at(id->second)->edges;
    edges.clear();
    layers_->links().find(key)->forEachEdge([&](const GridIndex& to, double clearance_m) {
      const PlaceId other = id_of_key_.at(to);
      if (id->second < other) edges.push_back({id->second, other, clearance_m});
    });
    std::sort(edges.begin(), edges.end(), isBefore);
    const auto isSame = [](const PlaceEdge& a, const PlaceEdge& b) { return a.b == b.b; };
    edges.erase(std::unique(edges.begin(), edges.end(), isSame), edges.end());
    edges.shrink_to_fit();
  }
}

void PlaceExtractor::addView(const RgbdFrame& frame, const Embedding& image_embedding) {
  const bool fits = embedding_size_ == 0 || image_embedding.size() == embedding_size_;
  if (!fits || !hasDirection(image_embedding) || !hasUsableDepth(frame) ||
      !frame.T_world_camera.matrix().allFinite()) {
    ++counters_.ignored_views;
    return;
  }
  embedding_size_ = image_embedding.size();
  const View& view = views_.add(makeView(frame, image_embedding));
  const Eigen::Vector3d eye_m = frame.T_world_camera.translation();
  const Eigen::Vector3d reach_m = Eigen::Vector3d::Constant(config_.max_view_range_m);
  const GridIndex low = computeCube(eye_m - reach_m);
  const GridIndex size = computeCube(eye_m + reach_m) - low + GridIndex::Ones();
  for (int i = 0; i < size.prod(); ++i) {
    const GridIndex offset(i % size.x(), i / size.x() % size.y(), i / (size.x() * size.y()));
    const auto cube = cubes_.find(low + offset);
    if (cube == cubes_.end()) continue;
    for (const PlaceId id : cube->second) places_.at(id)->addView(views_, view);
  }
  ++counters_.views;
  counters_.forgotten_views = views_.numForgotten();
}

PlaceGraph PlaceExtractor::graph() const {
  PlaceGraph graph;
  graph.stamp = stamp_;
  graph.places.reserve(places_.size());
  for (const auto& [id, state] : places_) {
    graph.places.push_back(state->place);
    graph.edges.insert(graph.edges.end(), state->edges.begin(), state->edges.end());
  }
  return graph;
}

}  // namespace tsg::places
