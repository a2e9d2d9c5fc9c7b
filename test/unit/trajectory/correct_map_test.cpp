// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/correct_map.h"

#include <gtest/gtest.h>

#include "graph_worlds.h"
#include "task_scene_graph/map/merge.h"

namespace tsg::trajectory {
namespace {

constexpr double kVoxel_m = 0.05;
constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// A keyframe each second and metre along x.
Keyframes makeWay(int num = 20) {
  Keyframes keyframes("map");
  for (int i = 0; i < num; ++i) keyframes.add({i * kSecond_ns}, makePose(i, 0.0, 1.5));
  return keyframes;
}

Mesh makeTriangle(const Eigen::Vector3f& at_m) {
  Mesh mesh;
  mesh.vertices = {at_m, at_m + Eigen::Vector3f(0.1F, 0.0F, 0.0F),
                   at_m + Eigen::Vector3f(0.0F, 0.1F, 0.0F)};
  mesh.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

ObjectPrimitivePtr makePrimitive(std::uint64_t id, double seen_s, const Eigen::Vector3f& at_m) {
  auto primitive = std::make_shared<ObjectPrimitive>();
  primitive->id = PrimitiveId{id};
  primitive->track = TrackId{id};
  primitive->mesh = makeTriangle(at_m);
  primitive->box = primitive->mesh.computeBounds();
  primitive->oriented_box = computeOrientedBox(primitive->mesh.vertices);
  primitive->oriented_box.size_m.z() = 0.3;
  primitive->first_seen = Stamp::fromSeconds(seen_s - 0.5);
  primitive->views.best.stamp = Stamp::fromSeconds(seen_s);
  primitive->last_seen = Stamp::fromSeconds(seen_s + 0.5);
  return primitive;
}

PlaceGraph makePlaces() {
  PlaceGraph graph;
  graph.stamp = Stamp::fromSeconds(19.0);
  for (std::uint64_t i = 1; i <= 18; ++i) {
    graph.places.push_back({PlaceId{i}, {static_cast<double>(i), 0.3, 1.0}, 0.5, {}, 0});
    if (i > 1) graph.edges.push_back({PlaceId{i - 1}, PlaceId{i}, 0.4});
  }
  return graph;
}

/// One triangle in each block along x, 0.4 m apart.
std::vector<mapping::BlockMesh> makeBlocks() {
  std::vector<mapping::BlockMesh> blocks;
  for (int i = 0; i < 45; ++i) {
    const auto mesh = makeTriangle({0.4F * static_cast<float>(i) + 0.1F, 0.1F, 0.1F});
    blocks.push_back({mapping::GridIndex(i, 0, 0), std::make_shared<const Mesh>(mesh)});
  }
  return blocks;
}

map::Map makeMap() {
  map::Map map("map");
  map.addPrimitives(
      {makePrimitive(1, 3.0, {3.0F, 1.0F, 0.5F}), makePrimitive(2, 16.0, {16.0F, 1.0F, 0.5F})});
  map.setPlaces(std::make_shared<const PlaceGraph>(makePlaces()));
  map.setMesh(kVoxel_m, makeBlocks());
  auto trajectory = std::make_shared<Trajectory>();
  for (int i = 0; i < 190; ++i) trajectory->add({i * kSecond_ns / 10}, makePose(0.1 * i, 0.0, 1.5));
  map.setTrajectory(trajectory);
  return map;
}

/// All vertices of all blocks, by block.
std::vector<Eigen::Vector3f> listVertices(const map::Map& map) {
  std::vector<Eigen::Vector3f> vertices;
  for (const auto& block : map.meshBlocks()) {
    vertices.insert(vertices.end(), block.mesh->vertices.begin(), block.mesh->vertices.end());
  }
  return vertices;
}

TEST(CorrectMap, TheIdentityLeavesAllPartsTheSame) {
  const map::Map map = makeMap();
  const Keyframes keyframes = makeWay();
  const CorrectedMap corrected =
      correctMap(map, keyframes, computeCorrection(keyframes, keyframes));
  EXPECT_EQ(corrected.num_moved_primitives, 0U);
  EXPECT_EQ(corrected.map.primitives(), map.primitives());  // the same pointers
  EXPECT_EQ(corrected.map.places(), map.places());
  EXPECT_EQ(corrected.map.trajectory(), map.trajectory());
  EXPECT_EQ(corrected.map.placeMemory(), map.placeMemory());
  for (std::size_t i = 0; i < map.meshBlocks().size(); ++i) {
    EXPECT_EQ(corrected.map.meshBlocks()[i].mesh, map.meshBlocks()[i].mesh);
  }
}

TEST(CorrectMap, AShiftMovesEverythingByIt) {
  const map::Map map = makeMap();
  const Keyframes keyframes = makeWay();
  const Eigen::Vector3d shift_m(0.5, -0.25, 2.0);  // exact in single precision
  const Pose T = makePose(shift_m.x(), shift_m.y(), shift_m.z());
  const map::Map moved = correctMap(map, keyframes, makeRigidCorrection(keyframes, T)).map;
  ASSERT_EQ(moved.primitives().size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const ObjectPrimitive& before = *map.primitives()[i];
    const ObjectPrimitive& after = *moved.primitives()[i];
    EXPECT_EQ(after.id, before.id);
    for (std::size_t v = 0; v < 3; ++v) {
      EXPECT_TRUE(after.mesh.vertices[v].isApprox(before.mesh.vertices[v] + shift_m.cast<float>()));
    }
    EXPECT_TRUE(after.box.center().isApprox(before.box.center() + shift_m, 1e-6));
    EXPECT_TRUE(after.oriented_box.center_m.isApprox(before.oriented_box.center_m + shift_m, 1e-6));
    EXPECT_EQ(after.oriented_box.size_m.z(), before.oriented_box.size_m.z());
  }
  for (std::size_t i = 0; i < 18; ++i) {
    EXPECT_TRUE(moved.places()->places[i].position_m.isApprox(
        map.places()->places[i].position_m + shift_m, 1e-12));
  }
  EXPECT_EQ(moved.places()->edges.size(), map.places()->edges.size());
  const auto before_m = listVertices(map);
  const auto after_m = listVertices(moved);
  ASSERT_EQ(after_m.size(), before_m.size());
  for (std::size_t i = 0; i < before_m.size(); ++i) {
    EXPECT_LT((after_m[i] - before_m[i] - shift_m.cast<float>()).norm(), 1e-5F);
  }
  EXPECT_TRUE(moved.trajectory()->poses().at(kSecond_ns).isApprox(T * makePose(1.0, 0.0, 1.5)));
  EXPECT_EQ(moved.worldFrame(), "map");
}

TEST(CorrectMap, EachThingFollowsTheKeyframesThatSawIt) {
  const map::Map map = makeMap();
  const Keyframes keyframes = makeWay();
  std::vector<KeyframeMotion> motions;
  for (const Keyframe& keyframe : keyframes.list()) {
    const bool moves = keyframe.id.value > 12;
    motions.push_back({keyframe.id, moves ? makePose(0.0, 0.5, 0.0) : Pose::Identity()});
  }
  const CorrectedMap corrected = correctMap(map, keyframes, Correction(motions));
  EXPECT_EQ(corrected.num_moved_primitives, 1U);
  EXPECT_EQ(corrected.map.primitives()[0], map.primitives()[0]);
  EXPECT_TRUE(corrected.map.primitives()[1]->box.center().isApprox(
      map.primitives()[1]->box.center() + Eigen::Vector3d(0.0, 0.5, 0.0), 1e-6));
  EXPECT_EQ(corrected.map.places()->places[4].position_m, map.places()->places[4].position_m);
  EXPECT_NEAR(corrected.map.places()->places[16].position_m.y(), 0.8, 1e-12);
  EXPECT_EQ(corrected.map.meshBlocks()[0].mesh, map.meshBlocks()[0].mesh);
  EXPECT_GT(corrected.num_moved_blocks, 10U);
  EXPECT_LT(corrected.num_moved_blocks, 25U);
  EXPECT_EQ(listVertices(corrected.map).size(), listVertices(map).size());
}

TEST(CorrectMap, WhereAnObjectWasSeenWhileTheWayBentItMovesAsTheMeanOfItsViews) {
  const Keyframes keyframes = makeWay();
  std::vector<KeyframeMotion> motions;
  for (const Keyframe& keyframe : keyframes.list()) {
    const double i = static_cast<double>(keyframe.id.value - 1);
    motions.push_back({keyframe.id, makePose(0.0, i, 0.0)});
  }
  auto primitive = *makePrimitive(1, 3.0, {3.0F, 1.0F, 0.5F});  // seen at 2.5, 3, 3.5 s
  const Correction correction(motions);
  EXPECT_NEAR(computeMotion(primitive, keyframes, correction).translation().y(), 3.0, 1e-12);
  primitive.views.best.stamp = Stamp::fromSeconds(3.3);
  EXPECT_NEAR(computeMotion(primitive, keyframes, correction).translation().y(), 3.1, 1e-12);
  primitive.views.best.stamp = Stamp{};  // not known
  EXPECT_NEAR(computeMotion(primitive, keyframes, correction).translation().y(), 3.0, 1e-12);
}

TEST(CorrectMap, TrianglesChangeTheirBlockAndShareIt) {
  const Keyframes way = makeWay();
  Deformation deformation(way, makeRigidCorrection(way, makePose(0.4, 0.0, 0.0)));
  std::vector<mapping::BlockMesh> blocks = makeBlocks();
  blocks.resize(2);
  auto moved = moveMesh(blocks, kVoxel_m, deformation);
  ASSERT_EQ(moved.size(), 2U);
  EXPECT_EQ(moved[0].block, mapping::GridIndex(1, 0, 0));
  EXPECT_EQ(moved[1].block, mapping::GridIndex(2, 0, 0));
  EXPECT_EQ(moved[1].mesh->colors[2], (std::array<std::uint8_t, 3>{7, 8, 9}));

  std::vector<KeyframeMotion> motions;
  for (const Keyframe& keyframe : way.list()) {
    const bool moves = keyframe.id.value > 10;
    motions.push_back({keyframe.id, moves ? makePose(-16.0, 0.0, 0.0) : Pose::Identity()});
  }
  Deformation fold(way, Correction(motions));
  blocks = {makeBlocks()[2], makeBlocks()[42]};
  moved = moveMesh(blocks, kVoxel_m, fold);
  ASSERT_EQ(moved.size(), 1U);
  EXPECT_EQ(moved[0].mesh->triangles.size(), 2U);
  EXPECT_EQ(moved[0].mesh->triangles[1], (std::array<std::uint32_t, 3>{3, 4, 5}));
}

TEST(CorrectMap, MovedThereAndBackItIsAsBefore) {
  const map::Map map = makeMap();
  const Keyframes keyframes = makeWay();
  const Pose T = makePose(1.0, 2.0, 0.5, 0.7);
  const map::Map there = correctMap(map, keyframes, makeRigidCorrection(keyframes, T)).map;
  const Keyframes moved = applyCorrection(makeRigidCorrection(keyframes, T), keyframes);
  const map::Map back = correctMap(there, moved, makeRigidCorrection(moved, T.inverse())).map;
  EXPECT_TRUE(back.primitives()[1]->mesh.vertices[2].isApprox(map.primitives()[1]->mesh.vertices[2],
                                                              1e-5F));
  EXPECT_TRUE(back.places()->places[7].position_m.isApprox(map.places()->places[7].position_m));
  const auto expected_m = listVertices(map);
  const auto found_m = listVertices(back);
  ASSERT_EQ(found_m.size(), expected_m.size());
  EXPECT_EQ(back.meshBlocks().size(), map.meshBlocks().size());
}

TEST(CorrectMap, MeshesAreTheSameForAnyNumberOfThreads) {
  const Keyframes way = makeWay();
  std::vector<KeyframeMotion> motions;
  for (const Keyframe& keyframe : way.list()) {
    const double i = static_cast<double>(keyframe.id.value);
    motions.push_back({keyframe.id, makePose(0.1 * i, -0.2, 0.0, 0.01 * i)});
  }
  std::vector<mapping::BlockMesh> expected;
  for (const int num_threads : {1, 2, 7}) {
    Deformation deformation(way, Correction(motions));
    const auto moved = moveMesh(makeBlocks(), kVoxel_m, deformation, num_threads);
    if (expected.empty()) expected = moved;
    ASSERT_EQ(moved.size(), expected.size());
    for (std::size_t i = 0; i < moved.size(); ++i) {
      EXPECT_EQ(moved[i].block, expected[i].block);
      EXPECT_EQ(moved[i].mesh->vertices, expected[i].mesh->vertices);
      EXPECT_EQ(moved[i].mesh->triangles, expected[i].mesh->triangles);
    }
  }
}

TEST(CorrectMap, WhatWasSeenTwiceIsOneObjectWithTheIdOfTheFirst) {
  map::Map map = makeMap();
  auto twin = *makePrimitive(2, 16.0, {3.0F, 6.0F, 0.5F});  // seen from a way 5 m off
  auto first = *map.primitives()[0];
  for (ObjectPrimitive* primitive : {&first, &twin}) {
    primitive->embedding = Embedding::Unit(4, 0);
    primitive->mesh.vertices[2].z() += 0.1F;  // a box with a volume
    primitive->box = primitive->mesh.computeBounds();
  }
  map.addPrimitives({std::make_shared<const ObjectPrimitive>(first),
                     std::make_shared<const ObjectPrimitive>(twin)});
  scene_graph::TaskList tasks;
  tasks.names = {"cups"};
  tasks.embeddings = EmbeddingMatrix(1, 4);
  tasks.embeddings.row(0) = Embedding::Unit(4, 0);
  map.setTasks(tasks, tasks);
  map::recluster(map);
  ASSERT_EQ(map.objectClusters().size(), 2U);
  const ObjectId id = map.objectClusters()[0].id;
  const Keyframes keyframes = makeWay();
  std::vector<KeyframeMotion> motions;
  for (const Keyframe& keyframe : keyframes.list()) {
    const bool moves = keyframe.id.value > 10;
    motions.push_back({keyframe.id, moves ? makePose(0.0, -5.0, 0.0) : Pose::Identity()});
  }
  map::Map corrected = correctMap(map, keyframes, Correction(motions)).map;
  joinMap({}, corrected);
  ASSERT_EQ(corrected.objectClusters().size(), 1U);
  EXPECT_EQ(corrected.objectClusters()[0].primitives.size(), 2U);
  EXPECT_EQ(corrected.objectClusters()[0].id, id);
}

TEST(CorrectMap, MapsOfOtherFramesAndWithoutKeyframesAreRejected) {
  const map::Map map = makeMap();
  const Keyframes other("odom");
  try {
    correctMap(map, other, Correction({}));
    ADD_FAILURE();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "the keyframes are in frame 'odom', expected the map's, 'map'");
  }
  const Correction correction = makeRigidCorrection(makeWay(), makePose(1.0, 0.0, 0.0));
  EXPECT_THROW(correctMap(map, Keyframes("map"), correction), std::invalid_argument);
  EXPECT_THROW(correctMap(map, makeWay(30), correction), std::invalid_argument);
}

}  // namespace
}  // namespace tsg::trajectory
