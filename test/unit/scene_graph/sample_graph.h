// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "task_scene_graph/scene_graph/scene_graph.h"

namespace tsg::scene_graph {

inline Embedding makeEmbedding(std::initializer_list<float> values) {
  Embedding embedding(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), embedding.data());
  return embedding;
}

inline Mesh makeTetrahedron(const Eigen::Vector3f& corner_m) {
  Mesh mesh;
  for (const Eigen::Vector3f& offset_m : {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 0, 0),
                                          Eigen::Vector3f(0, 1, 0), Eigen::Vector3f(0, 0, 1)}) {
    mesh.vertices.push_back(corner_m + offset_m);
    mesh.colors.push_back({10, 20, 30});
  }
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

inline ObjectPrimitivePtr makePrimitive(std::uint64_t id, const Eigen::Vector3d& corner_m,
                                        Embedding embedding) {
  auto primitive = std::make_shared<ObjectPrimitive>();
  primitive->id = {id};
  primitive->track = {id + 100};
  primitive->mesh = makeTetrahedron(corner_m.cast<float>());
  primitive->box = makeAabb(corner_m, corner_m + Eigen::Vector3d::Ones());
  primitive->oriented_box = toOrientedBox(primitive->box);
  primitive->embedding = std::move(embedding);
  primitive->first_seen = Stamp{1600000000123456789 + static_cast<std::int64_t>(id)};
  primitive->last_seen = Stamp{1600000009876543210 + static_cast<std::int64_t>(id)};
  primitive->num_observations = 5;
  return primitive;
}

inline PlaceGraphPtr makePlaces() {
  auto places = std::make_shared<PlaceGraph>();
  places->stamp = Stamp{1600000010000000000};
  places->places = {{{1}, {0.5, 0.25, 1.0}, 0.75, makeEmbedding({0.1F, 0.9F, 0}), 3},
                    {{2}, {1.5, 0.25, 1.0}, 0.5, makeEmbedding({0.3F, 0.7F, 0}), 2},
                    {{4}, {4.0, 0.0, 1.0}, 1.25, makeEmbedding({0.9F, 0.1F, 0.2F}), 1},
                    {{7}, {9.0, 0.0, 1.0}, 1.0, Embedding(), 0}};
  places->edges = {{{1}, {2}, 0.5}, {{2}, {4}, 0.375}, {{4}, {7}, 0.25}};
  return places;
}

/// A graph that has every case: a primitive and a place without embedding, an object whose place is
/// in no region, an object without a place, a region without a name, words that are not ASCII.
inline SceneGraph makeSampleGraph() {
  SceneGraph graph;
  graph.stamp = Stamp{1600000010000000000};
  graph.object_tasks = {"wash the \"dishes\"", "Kissen holen: für mich", "nothing serves this"};
  graph.place_tasks = {"kitchen", "office"};
  graph.primitives = {makePrimitive(1, {0, 0, 0}, makeEmbedding({1, 0.1F, 0})),
                      makePrimitive(2, {0.5, 0, 0}, makeEmbedding({0.8F, 0.3F, 0})),
                      makePrimitive(3, {9, 0, 0}, makeEmbedding({0, 1.0F / 3.0F, 1e-7F})),
                      makePrimitive(9, {20, 0, 0}, Embedding())};
  graph.places = makePlaces();
  const auto& p = graph.primitives;
  graph.objects = {{{5},
                    graph.object_tasks[0],
                    0,
                    0.875,
                    makeAabb({0, 0, 0}, {1.5, 1, 1}),
                    OrientedBox{{0.75, 0.5, 0.5}, {1.25, 0.75, 1}, 0.25},
                    {0.75, 0.5, 0.5},
                    {{1}, {2}},
                    makeEmbedding({0.9F, 0.2F, 0}),
                    p[0]->first_seen,
                    p[1]->last_seen,
                    {1}},
                   {{6},
                    graph.object_tasks[1],
                    1,
                    0.25,
                    p[2]->box,
                    toOrientedBox(p[2]->box),
                    {9.5, 0.5, 0.5},
                    {{3}},
                    p[2]->embedding,
                    p[2]->first_seen,
                    p[2]->last_seen,
                    {7}},
                   {{8},
                    graph.object_tasks[1],
                    1,
                    0.25,
                    p[2]->box,
                    toOrientedBox(p[2]->box),
                    {9.5, 0.5, 0.5},
                    {{9}},
                    p[2]->embedding,
                    p[2]->first_seen,
                    p[2]->last_seen,
                    {}}};
  graph.regions = {{{2},
                    "kitchen",
                    0,
                    0.5,
                    {0.5, 0.25, 1.0},
                    {{1}, {2}},
                    makeEmbedding({0.2F, 0.8F, 0}),
                    1.5,
                    {{0, 0}, {1.5, 0}, {1.5, 1}, {0, 1}},
                    {{2}},
                    {}},
                   {{11},
                    "",
                    -1,
                    0.125,
                    {4.0, 0.0, 1.0},
                    {{4}},
                    makeEmbedding({0.9F, 0.1F, 0.2F}),
                    0.0,
                    {},
                    {{4}},
                    {}}};
  graph.region_edges = {{{2}, {11}, 0.375, 2.0, 0.5}};
  return graph;
}

}  // namespace tsg::scene_graph
