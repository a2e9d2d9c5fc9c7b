// SPDX-License-Identifier: BSD-3-Clause
#include "place_features.h"

#include <algorithm>

#include "task_scene_graph/scene_graph/scoring.h"

namespace tsg::scene_graph {
namespace {

bool isBefore(const PlaceEdge& left, const PlaceEdge& right) {
  return left.a == right.a ? left.b < right.b : left.a < right.a;
}

std::vector<PlaceEdge> sortEdges(std::vector<PlaceEdge> edges) {
  if (!std::is_sorted(edges.begin(), edges.end(), isBefore)) {
    std::sort(edges.begin(), edges.end(), isBefore);
  }
  return edges;
}

/// Marks the places at edges that the other graph has not, or with another clearance.
void markEdges(const PlaceIndex& index, const std::vector<PlaceEdge>& edges,
               const std::vector<PlaceEdge>& others, std::vector<char>& is_marked) {
  auto other = others.begin();
  for (const PlaceEdge& edge : edges) {
    while (other != others.end() && isBefore(*other, edge)) ++other;
    const bool is_there = other != others.end() && !isBefore(edge, *other);
    if (is_there && other->clearance_m == edge.clearance_m) continue;
    for (const PlaceId id : {edge.a, edge.b}) {
      const std::size_t i = index.find(id);
      if (i != PlaceIndex::kNone) is_marked[i] = 1;
    }
  }
}

}  // namespace

/// Marks places whose embedding is another than at the last call. A usable one is of the size,
/// finite and not zero; what has not changed is not looked at again.
PlaceFeatures::Looked PlaceFeatures::lookAt(const PlaceGraphPtr& graph, Eigen::Index size,
                                            std::vector<char>& has_other,
                                            UnusablePlaces& unusable) {
  for (const Place& place : graph->places) {
    if (size > 0) break;
    size = place.embedding.size();
  }
  Looked now{graph, PlaceIndex(*graph), std::vector<Own>(graph->places.size(), Own::kNone),
             sortEdges(graph->edges), size};
  changed_.clear();
  for (std::size_t i = 0; i < graph->places.size(); ++i) {
    const Place& place = graph->places[i];
    const std::size_t k = last_.graph ? last_.index.find(place.id) : PlaceIndex::kNone;
    const Place* old = k == PlaceIndex::kNone ? nullptr : &last_.graph->places[k];
    const SharedEmbedding& embedding = place.embedding;
    const bool is_same = old != nullptr && old->embedding == embedding;
    if (is_same && last_.embedding_size == size) {
      now.own[i] = last_.own[k];
      has_other[i] = 0;
    } else if (embedding.size() > 0) {
      const bool is_valid = embedding.size() == size && embedding->allFinite();
      now.own[i] = !is_valid                  ? Own::kRejected
                   : embedding.hasDirection() ? Own::kUsable
                                              : Own::kNone;
    }
    if (has_other[i] != 0 || old->position_m != place.position_m ||
        old->clearance_m != place.clearance_m) {
      changed_.push_back(place.id);
    }
    if (now.own[i] != Own::kRejected) continue;
    ++unusable.rejected;
    if (!unusable.error.empty()) continue;
    unusable.error = "place " + std::to_string(place.id.value) + " has an embedding of " +
                     std::to_string(embedding.size()) + " values, expected " +
                     std::to_string(size) + " finite ones";
  }
  return now;
}

/// Marks what smoothing takes the changed embeddings to, and what edges changed.
void PlaceFeatures::markNeighbours(const Looked& now, std::vector<char>& is_changed) const {
  const std::vector<char> has_other = is_changed;
  for (const PlaceEdge& edge : now.edges) {
    const std::size_t a = now.index.find(edge.a);
    const std::size_t b = now.index.find(edge.b);
    if (has_other[a] != 0) is_changed[b] = 1;
    if (has_other[b] != 0) is_changed[a] = 1;
  }
  if (!last_.graph) return;
  markEdges(now.index, now.edges, last_.edges, is_changed);
  markEdges(now.index, last_.edges, now.edges, is_changed);
}

/// By place; empty where nothing was to do, or where neither the place nor, with smoothing, a
/// neighbour has a usable embedding. Sums run over the place itself, then over the edges in order.
std::vector<Embedding> PlaceFeatures::computeFeatures(const Looked& now,
                                                      const std::vector<char>& is_changed) const {
  const auto& places = now.graph->places;
  std::vector<Embedding> sums(places.size());
  std::vector<double> totals(places.size(), 0.0);
  const auto add = [&](std::size_t to, std::size_t from, double weight) {
    if (is_changed[to] == 0 || now.own[to] == Own::kRejected) return;
    if (now.own[from] != Own::kUsable || !(weight > 0.0)) return;
    if (sums[to].size() == 0) sums[to].setZero(now.embedding_size);
    sums[to] += static_cast<float>(weight) * *places[from].embedding;
    totals[to] += weight;
  };
  for (std::size_t i = 0; i < places.size(); ++i) add(i, i, 1.0);
  for (const PlaceEdge& edge : now.edges) {
    if (smoothing_per_m_ == 0.0) break;
    const std::size_t a = now.index.find(edge.a);
    const std::size_t b = now.index.find(edge.b);
    add(a, b, smoothing_per_m_ * edge.clearance_m);
    add(b, a, smoothing_per_m_ * edge.clearance_m);
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (sums[i].size() == 0) continue;
    sums[i] /= static_cast<float>(totals[i]);
    if (!hasDirection(sums[i])) sums[i].resize(0);
  }
  return sums;
}

void PlaceFeatures::replaceFeatures(const Looked& now, const std::vector<char>& is_changed,
                                    std::vector<Embedding> computed) {
  std::vector<PlaceFeature> features;
  features.reserve(now.graph->places.size());
  auto old = features_.begin();
  for (std::size_t i = 0; i < computed.size(); ++i) {
    const Place& place = now.graph->places[i];
    if (is_changed[i] != 0) {
      if (computed[i].size() == 0) continue;
      features.push_back({&place, std::move(computed[i]), next_version_++});
      continue;
    }
    while (old != features_.end() && old->place->id < place.id) ++old;
    if (old == features_.end() || old->place->id != place.id) continue;  // it had none
    features.push_back({&place, std::move(old->feature), old->version});
  }
  features_ = std::move(features);
}

UnusablePlaces PlaceFeatures::update(const PlaceGraphPtr& graph, Eigen::Index size,
                                     double smoothing_per_m) {
  UnusablePlaces unusable;
  const bool is_anew = !last_.graph || smoothing_per_m != smoothing_per_m_;
  smoothing_per_m_ = smoothing_per_m;
  std::vector<char> is_changed(graph->places.size(), 1);
  Looked now = lookAt(graph, size, is_changed, unusable);
  if (is_anew) is_changed.assign(is_changed.size(), 1);
  if (smoothing_per_m > 0.0) markNeighbours(now, is_changed);
  replaceFeatures(now, is_changed, computeFeatures(now, is_changed));
  last_ = std::move(now);
  return unusable;
}

}  // namespace tsg::scene_graph
