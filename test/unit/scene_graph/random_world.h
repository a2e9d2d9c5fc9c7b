// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/scene_graph/tasks.h"

namespace tsg::scene_graph {

/// Seeded primitives and places whose cosines to the tasks lie on both sides of the usual alpha.
class RandomWorld {
 public:
  static constexpr Eigen::Index kSize = 16;

  explicit RandomWorld(unsigned seed, int num_tasks = 4) : random_(seed) {
    for (int t = 0; t < num_tasks; ++t) tasks_.names.push_back("task " + std::to_string(t));
    tasks_.embeddings.resize(num_tasks, kSize);
    for (int t = 0; t < num_tasks; ++t) tasks_.embeddings.row(t) = makeNoise().transpose();
  }

  const TaskList& tasks() const { return tasks_; }

  /// `weight` of a random task plus noise: 0 = pure noise, large = serves that task.
  Embedding makeEmbedding(float weight) {
    const auto task = drawIndex(tasks_.names.size());
    return weight * tasks_.embeddings.row(static_cast<Eigen::Index>(task)).transpose() +
           makeNoise();
  }

  /// Boxes of 0.4 to 1.2 m in a hall of side `side_m`; every tenth has no embedding.
  std::vector<ObjectPrimitivePtr> makePrimitives(int count, double side_m, std::uint64_t first_id) {
    std::vector<ObjectPrimitivePtr> primitives;
    for (int i = 0; i < count; ++i) {
      auto primitive = std::make_shared<ObjectPrimitive>();
      primitive->id = {first_id + static_cast<std::uint64_t>(i)};
      const Eigen::Vector3d corner_m(draw(0, side_m), draw(0, side_m), draw(0, 1));
      const Eigen::Vector3d size_m(draw(0.4, 1.2), draw(0.4, 1.2), draw(0.4, 1.2));
      primitive->box = makeAabb(corner_m, corner_m + size_m);
      if (draw(0, 1) > 0.1) primitive->embedding = makeEmbedding(static_cast<float>(draw(0, 1.5)));
      primitive->first_seen = Stamp::fromSeconds(draw(1, 50));
      primitive->last_seen = Stamp::fromSeconds(draw(50, 100));
      primitives.push_back(primitive);
    }
    return primitives;
  }

  Place makePlace(std::uint64_t id) {
    Place place;
    place.id = {id};
    place.position_m = {draw(0, 20), draw(0, 20), draw(0.8, 1.2)};
    place.clearance_m = draw(0.4, 2);
    if (draw(0, 1) > 0.15) place.embedding = makeEmbedding(static_cast<float>(draw(0, 1.5)));
    return place;
  }

  /// Places with distinct ids up to 3 * count, each joined to about two others.
  PlaceGraph makePlaces(int count) {
    PlaceGraph graph;
    std::uint64_t id = 0;
    for (int i = 0; i < count; ++i) {
      id += static_cast<std::uint64_t>(draw(1, 3.99));
      graph.places.push_back(makePlace(id));
    }
    for (int i = 0; i < count; ++i) addRandomEdge(graph);
    return graph;
  }

  void addRandomEdge(PlaceGraph& graph) {
    if (graph.places.size() < 2) return;
    const PlaceId a = graph.places[drawIndex(graph.places.size())].id;
    const PlaceId b = graph.places[drawIndex(graph.places.size())].id;
    if (a == b) return;
    const PlaceEdge edge{std::min(a, b), std::max(a, b), draw(0.25, 1)};
    const auto before = [](const PlaceEdge& x, const PlaceEdge& y) {
      return std::pair(x.a, x.b) < std::pair(y.a, y.b);
    };
    const auto spot = std::lower_bound(graph.edges.begin(), graph.edges.end(), edge, before);
    if (spot != graph.edges.end() && spot->a == edge.a && spot->b == edge.b) return;
    graph.edges.insert(spot, edge);
  }

  void removePlace(PlaceGraph& graph, std::size_t index) {
    const PlaceId id = graph.places.at(index).id;
    graph.places.erase(graph.places.begin() + static_cast<std::ptrdiff_t>(index));
    const auto touches = [&](const PlaceEdge& edge) { return edge.a == id || edge.b == id; };
    graph.edges.erase(std::remove_if(graph.edges.begin(), graph.edges.end(), touches),
                      graph.edges.end());
  }

  double draw(double min, double max) {
    return std::uniform_real_distribution<double>(min, max)(random_);
  }
  std::size_t drawIndex(std::size_t size) {
    return std::uniform_int_distribution<std::size_t>(0, size - 1)(random_);
  }
  std::mt19937& random() { return random_; }

 private:
  Embedding makeNoise() {
    std::normal_distribution<float> normal(0.0F, 1.0F);
    return Embedding::NullaryExpr(kSize, [&] { return normal(random_); });
  }

  std::mt19937 random_;
  TaskList tasks_;
};

/// Groups of joined items 0..count-1, each ascending, ascending by their first item: brute force.
template <typename IsJoined>
std::vector<std::vector<std::size_t>> findComponents(std::size_t count, const IsJoined& isJoined) {
  std::vector<std::size_t> label(count);
  for (std::size_t i = 0; i < count; ++i) label[i] = i;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < count; ++j) {
        if (label[j] >= label[i] || !isJoined(i, j)) continue;
        label[i] = label[j];
        changed = true;
      }
    }
  }
  std::vector<std::vector<std::size_t>> groups(count);
  for (std::size_t i = 0; i < count; ++i) groups[label[i]].push_back(i);
  groups.erase(
      std::remove_if(groups.begin(), groups.end(), [](const auto& g) { return g.empty(); }),
      groups.end());
  return groups;
}

}  // namespace tsg::scene_graph
