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

bool isUsableEmbedding(const Embedding& embedding) {
  return embedding.size() > 0 && embedding.allFinite() && !embedding.isZero(0.0F);
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
  const CellSet touched = layers_->update(voxels_, {changed.begin(), changed.end()});
  Changes changes = findChanges({touched.begin(), touched.end()});
  matchIds(changes);
  addPlaces(changes);
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
      places_.at(id->second).place.clearance_m = static_cast<double>(node->seed.clearance_m);
    } else {
      changes.removed.push_back(std::move(places_.at(id->second)));
      places_.erase(id->second);
      id_of_key_.erase(id);
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
    id_of_key_[state.key] = state.place.id;
    places_[state.place.id] = std::move(state);
  }
}

/// Ascending by (a, b).
std::vector<PlaceEdge> PlaceExtractor::collectEdges() const {
  std::vector<PlaceEdge> edges;
  for (const auto& [id, state] : places_) {
    const PlaceLinks::Node& node = *layers_->links().find(state.key);
    const auto first = static_cast<std::ptrdiff_t>(edges.size());
    const auto add = [&, own = id](const GridIndex& to, double clearance_m) {
      const PlaceId other = id_of_key_.at(to);
      if (own < other) edges.push_back({own, other, clearance_m});
    };
    node.forEachEdge(add);
    std::sort(edges.begin() + first, edges.end(), isBefore);
    const auto isSame = [](const PlaceEdge& a, const PlaceEdge& b) { return a.b == b.b; };
    edges.erase(std::unique(edges.begin() + first, edges.end(), isSame), edges.end());
  }
  return edges;
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
  for (auto& [id, state] : places_) state.addView(views_, view);
  ++counters_.views;
  counters_.forgotten_views = views_.numForgotten();
}

PlaceGraph PlaceExtractor::graph() const {
  PlaceGraph graph;
  graph.stamp = stamp_;
  graph.edges = collectEdges();
  graph.places.reserve(places_.size());
  for (const auto& [id, state] : places_) graph.places.push_back(state.place);
  return graph;
}

}  // namespace tsg::places
