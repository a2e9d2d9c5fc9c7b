// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/background_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include "synthetic_scene.h"
#include "task_scene_graph/mapping/marching_cubes.h"

namespace tsg::mapping {
namespace {

const CameraModel kCamera{160, 120, 131.0, 131.5, 79.5, 59.5};

/// A corridor along x with a ball every two metres.
std::vector<test::Solid> makeCorridor(int balls) {
  std::vector<test::Solid> scene{
      test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90}),
      test::makePlane({0, 1.2, 0}, {0, -1, 0}, {10, 200, 30}),
      test::makePlane({0, -1.2, 0}, {0, 1, 0}, {30, 20, 200}),
  };
  for (int i = 0; i < balls; ++i) {
    scene.push_back(test::makeSphere({2.0 * i, 0.3, 0.5}, 0.3, {200, 0, 0}));
  }
  return scene;
}

/// Looks forward along the corridor from x.
RgbdFrame renderAt(const std::vector<test::Solid>& scene, double x_m, double seconds) {
  auto frame =
      test::render(scene, kCamera, test::lookAt({x_m, 0, 1.2}, {x_m + 2.0, 0.1, 0.6})).frame;
  frame.stamp = Stamp::fromSeconds(seconds);
  return frame;
}

BackgroundConfig makeConfig() {
  BackgroundConfig config;
  config.tsdf.voxel_size_m = 0.1;
  config.tsdf.truncation_m = 0.3;
  config.tsdf.max_range_m = 4.0;
  return config;
}

using Corner = std::tuple<float, float, float>;

/// The triangles by position, in an order of their own: meshes are equal as surfaces.
std::vector<std::array<Corner, 3>> toTriangles(const Mesh& mesh) {
  std::vector<std::array<Corner, 3>> triangles;
  for (const auto& t : mesh.triangles) {
    std::array<Corner, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& v = mesh.vertices[t[i]];
      corners[i] = {v.x(), v.y(), v.z()};
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    triangles.push_back(corners);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

class MeshMirror {
 public:
  void apply(const MeshUpdate& update) {
    for (const auto& changed : update.changed) meshes_[key(changed.block)] = changed.mesh;
    for (const auto& block : update.removed) EXPECT_EQ(meshes_.erase(key(block)), 1U);
  }
  Mesh merge() const {
    Mesh all;
    for (const auto& [block, mesh] : meshes_) all.append(*mesh);
    return weldVertices(all);
  }

 private:
  static std::array<int, 3> key(const GridIndex& i) { return {i.x(), i.y(), i.z()}; }
  std::map<std::array<int, 3>, std::shared_ptr<const Mesh>> meshes_;
};

TEST(BackgroundMap, IncrementalMeshIsTheMeshOfTheWholeVolume) {
  const auto scene = makeCorridor(5);
  BackgroundConfig config = makeConfig();
  config.archive_blocks = false;
  BackgroundMap map(config);
  MeshMirror mirror;
  for (int i = 0; i < 12; ++i) {
    map.integrate(renderAt(scene, 0.4 * i, 0.1 * i));
    if (i % 3 == 2) mirror.apply(map.updateMesh());
  }
  const auto expected = toTriangles(computeMesh(map.volume(), config.mesh_min_weight));
  ASSERT_GT(expected.size(), 1000U);
  EXPECT_EQ(toTriangles(mirror.merge()), expected);
  EXPECT_EQ(toTriangles(map.extractMesh()), expected);
}

TEST(BackgroundMap, ExtractedMeshIncludesChangesNotYetReported) {
  BackgroundMap map(makeConfig());
  map.integrate(renderAt(makeCorridor(3), 0.0, 0.0));
  const auto before = toTriangles(map.extractMesh());
  EXPECT_EQ(before, toTriangles(computeMesh(map.volume(), map.config().mesh_min_weight)));
  map.updateMesh();
  EXPECT_EQ(toTriangles(map.extractMesh()), before);
}

TEST(BackgroundMap, UnchangedBlocksAreNotMeshedAgain) {
  const auto scene = makeCorridor(5);
  BackgroundMap map(makeConfig());
  map.integrate(renderAt(scene, 0.0, 0.0));
  const auto first = map.updateMesh();
  EXPECT_FALSE(first.changed.empty());
  EXPECT_TRUE(map.updateMesh().changed.empty());

  const auto result = map.integrate(renderAt(scene, 3.5, 0.1));
  const auto second = map.updateMesh();
  for (const auto& changed : second.changed) {
    const bool reads_a_change =
        std::any_of(result.changed_blocks.begin(), result.changed_blocks.end(), [&](const auto& b) {
          const GridIndex step = b - changed.block;
          return step.minCoeff() >= 0 && step.maxCoeff() <= 1;
        });
    EXPECT_TRUE(reads_a_change);
  }
  const std::size_t blocks_with_mesh = first.changed.size() + second.changed.size();
  EXPECT_GT(blocks_with_mesh, second.changed.size());
}

TEST(BackgroundMap, BlocksThatLostTheirSurfaceAreReportedAsRemoved) {
  BackgroundConfig config = makeConfig();
  config.tsdf.carve_free_space = true;
  BackgroundMap map(config);
  auto scene = makeCorridor(0);
  const auto empty = scene;
  scene.push_back(test::makeSphere({1.8, 0, 1.0}, 0.2, {1, 2, 3}));
  MeshMirror mirror;
  map.integrate(renderAt(scene, 0.0, 0.0));
  mirror.apply(map.updateMesh());
  std::size_t removed = 0;
  for (int i = 1; i <= 40; ++i) map.integrate(renderAt(empty, 0.0, 0.03 * i));
  const auto update = map.updateMesh();
  removed = update.removed.size();
  mirror.apply(update);
  EXPECT_GT(removed, 0U);
  EXPECT_EQ(toTriangles(mirror.merge()),
            toTriangles(computeMesh(map.volume(), config.mesh_min_weight)));
}

TEST(BackgroundMap, ArchivingDropsVoxelsAndKeepsTheMesh) {
  BackgroundConfig config = makeConfig();
  BackgroundMap map(config);
  map.integrate(renderAt(makeCorridor(4), 0.0, 0.0));
  MeshMirror mirror;
  mirror.apply(map.updateMesh());
  const auto before = toTriangles(map.extractMesh());
  auto blocks = map.volume().sortedBlockIndices();
  blocks.resize(blocks.size() / 2);
  map.archive(blocks);
  for (const auto& block : blocks) EXPECT_EQ(map.volume().findBlock(block), nullptr);
  EXPECT_EQ(map.counters().blocks_archived, blocks.size());
  EXPECT_TRUE(map.updateMesh().changed.empty());
  EXPECT_EQ(toTriangles(map.extractMesh()), before);
}

TEST(BackgroundMap, RevisitedPlacesKeepTheirMeshWithoutDoubleSurfaces) {
  const auto scene = makeCorridor(4);
  BackgroundMap map(makeConfig());
  MeshMirror mirror;
  map.integrate(renderAt(scene, 0.0, 0.0));
  mirror.apply(map.updateMesh());
  const auto before = toTriangles(map.extractMesh());
  map.archive(map.volume().sortedBlockIndices());
  EXPECT_TRUE(map.volume().blocks().empty());
  map.integrate(renderAt(scene, 0.0, 10.0));
  mirror.apply(map.updateMesh());
  EXPECT_EQ(toTriangles(mirror.merge()), before);

  // A view of a part only: nothing that was there before gets lost.
  map.archive(map.volume().sortedBlockIndices());
  map.integrate(renderAt(scene, 2.0, 20.0));
  const Mesh after = map.extractMesh();
  for (const auto& v : after.vertices) {
    EXPECT_LE(std::abs(test::computeSceneDistance(scene, v.cast<double>())), 0.1);
  }
  EXPECT_GE(after.triangles.size(), before.size());
}

TEST(BackgroundMap, MemoryOfALongWalkStaysFlat) {
  BackgroundConfig config = makeConfig();
  config.archive_distance_m = 5.0;
  config.archive_unseen_s = 2.0;
  BackgroundMap map(config);
  const auto scene = makeCorridor(12);
  std::size_t blocks_at_10_m = 0;
  std::size_t archived = 0;
  for (int i = 0; i <= 75; ++i) {
    const auto result = map.integrate(renderAt(scene, 0.4 * i, 0.5 * i));
    archived += result.archived_blocks.size();
    map.updateMesh();
    if (i == 25) blocks_at_10_m = map.volume().blocks().size();
  }
  EXPECT_GT(archived, 50U);
  EXPECT_EQ(archived, map.counters().blocks_archived);
  EXPECT_LE(map.volume().blocks().size(), blocks_at_10_m + blocks_at_10_m / 5);
  const Aabb bounds = map.extractMesh().computeBounds();
  EXPECT_LT(bounds.min().x(), 1.5);
  EXPECT_GT(bounds.max().x(), 31.0);
}

TEST(BackgroundMap, ArchivedMeshLeavesMemoryAndTakesAFractionOfItsSize) {
  BackgroundMap map(makeConfig());
  const auto scene = makeCorridor(6);
  for (int i = 0; i < 10; ++i) map.integrate(renderAt(scene, 0.5 * i, 0.1 * i));
  map.updateMesh();
  EXPECT_EQ(map.archive().fileBytes(), 0U);
  const Mesh before = map.extractMesh();
  map.archive(map.volume().sortedBlockIndices());
  const std::size_t plain_bytes = 15 * before.vertices.size() + 12 * before.triangles.size();
  EXPECT_GT(map.archive().fileBytes(), 0U);
  EXPECT_LT(map.archive().fileBytes(), plain_bytes / 2);
  EXPECT_EQ(map.archive().memoryBytes(), 0U);
  EXPECT_EQ(toTriangles(map.extractMesh()), toTriangles(before));
}

TEST(BackgroundMap, MeshesOfBlocksAreThoseReportedAlsoFromTheArchive) {
  const auto scene = makeCorridor(6);
  BackgroundMap map(makeConfig());
  MeshMirror mirror;
  for (int i = 0; i < 12; ++i) {
    map.integrate(renderAt(scene, 0.5 * i, 0.2 * i));
    mirror.apply(map.updateMesh());
    auto blocks = map.volume().sortedBlockIndices();
    blocks.resize(blocks.size() / 3);
    if (i % 4 == 3) map.archive(blocks);
  }
  mirror.apply(map.updateMesh());
  EXPECT_GT(map.archive().fileBytes(), 0U);
  Mesh all;
  for (const auto& block : map.meshes().blocks()) all.append(*map.meshes().find(block).load());
  EXPECT_EQ(toTriangles(weldVertices(all)), toTriangles(mirror.merge()));
  EXPECT_TRUE(map.meshes().find({1000, 0, 0}).isNone());
}

TEST(BackgroundMap, JumpsOfTheCameraAreCounted) {
  BackgroundMap map(makeConfig());
  const auto scene = makeCorridor(6);
  map.integrate(renderAt(scene, 0.0, 0.0));
  map.integrate(renderAt(scene, 0.5, 0.1));
  EXPECT_EQ(map.counters().pose_jumps, 0U);
  map.integrate(renderAt(scene, 4.5, 0.2));
  map.integrate(renderAt(scene, 4.6, 0.3));
  EXPECT_EQ(map.counters().pose_jumps, 1U);
  EXPECT_EQ(map.counters().frames_integrated, 4U);
}

TEST(BackgroundMap, WithoutMeshItIsATsdfOnly) {
  BackgroundConfig config = makeConfig();
  config.with_mesh = false;
  BackgroundMap map(config);
  map.integrate(renderAt(makeCorridor(2), 0.0, 0.0));
  EXPECT_FALSE(map.volume().blocks().empty());
  EXPECT_TRUE(map.updateMesh().changed.empty());
  EXPECT_TRUE(map.extractMesh().isEmpty());
}

TEST(BackgroundMap, OddStampsAreCountedAndNeverTurnTheClockBack) {
  BackgroundConfig config = makeConfig();
  config.archive_distance_m = 0.0;
  config.archive_unseen_s = 5.0;
  BackgroundMap map(config);
  const auto scene = makeCorridor(2);
  map.integrate(renderAt(scene, 0.0, 100.0));
  map.integrate(renderAt(scene, 0.0, 100.0));
  map.integrate(renderAt(scene, 0.0, 50.0));
  auto blind = renderAt(scene, 0.0, 103.0);
  blind.depth.image = cv::Mat(blind.depth.image.size(), CV_32FC1, cv::Scalar(0));
  map.integrate(blind);
  EXPECT_EQ(map.counters().frames_integrated, 3U);
  EXPECT_EQ(map.counters().frames_repeated, 1U);
  EXPECT_EQ(map.counters().frames_back_in_time, 1U);
  EXPECT_EQ(map.counters().frames_without_depth, 1U);
  EXPECT_EQ(map.counters().blocks_archived, 0U);
}

/// Blocks archived in each of two walks down the corridor.
std::array<std::size_t, 2> walkTwice(double second_start_s) {
  BackgroundConfig config = makeConfig();
  config.archive_distance_m = 5.0;
  config.archive_unseen_s = 2.0;
  BackgroundMap map(config);
  const auto scene = makeCorridor(12);
  std::array<std::size_t, 2> archived{};
  for (std::size_t pass = 0; pass < 2; ++pass) {
    const double start_s = pass == 0 ? 1000.0 : second_start_s;
    for (int i = 0; i <= 40; ++i) {
      archived[pass] +=
          map.integrate(renderAt(scene, 0.5 * i, start_s + 0.5 * i)).archived_blocks.size();
    }
  }
  return archived;
}

TEST(BackgroundMap, ABagPlayedInALoopIsArchivedInEachPassAlike) {
  const auto archived = walkTwice(1000.0);
  EXPECT_GT(archived[0], 100U);
  EXPECT_GE(archived[1], archived[0]);  // and what the first pass left at the far end
}

TEST(BackgroundMap, ArchivingGoesOnWhenStampsBeginAnewAtZero) {
  EXPECT_EQ(walkTwice(0.0), walkTwice(1000.0));
}

TEST(BackgroundMap, AnExtractedTableIsThatOfItsMomentWhateverComesLater) {
  BackgroundMap map(makeConfig());
  const auto scene = makeCorridor(6);
  map.integrate(renderAt(scene, 0.0, 0.0));
  map.updateMesh();
  map.archive(map.volume().sortedBlockIndices());
  const MeshTable before = map.meshes();
  const auto expected = toTriangles(mergeMeshes(before));
  for (int i = 1; i < 6; ++i) {  // every block is seen, meshed and archived again
    map.integrate(renderAt(scene, 0.1 * i, 1.0 * i));
    map.updateMesh();
    map.archive(map.volume().sortedBlockIndices());
  }
  EXPECT_EQ(toTriangles(mergeMeshes(before)), expected);
  EXPECT_NE(toTriangles(mergeMeshes(map.meshes())), expected);
}

TEST(BackgroundMap, WithoutMeshChangedBlocksAreTakenOnce) {
  BackgroundConfig config = makeConfig();
  config.with_mesh = false;
  BackgroundMap map(config);
  const auto result = map.integrate(renderAt(makeCorridor(2), 0.0, 0.0));
  const TsdfVolume changed = map.takeChangedBlocks();
  EXPECT_EQ(changed.sortedBlockIndices(), result.changed_blocks);
  for (const auto& index : result.changed_blocks) {
    EXPECT_EQ(changed.findBlock(index)->voxels[100].weight,
              map.volume().findBlock(index)->voxels[100].weight);
  }
  EXPECT_TRUE(map.takeChangedBlocks().blocks().empty());
}

TEST(BackgroundMap, ThreadCountDoesNotChangeUpdates) {
  const auto scene = makeCorridor(3);
  std::vector<MeshUpdate> updates;
  for (const int threads : {1, 4}) {
    BackgroundConfig config = makeConfig();
    config.tsdf.num_threads = threads;
    BackgroundMap map(config);
    map.integrate(renderAt(scene, 0.0, 0.0));
    map.integrate(renderAt(scene, 0.5, 0.1));
    updates.push_back(map.updateMesh());
  }
  ASSERT_EQ(updates[0].changed.size(), updates[1].changed.size());
  for (std::size_t i = 0; i < updates[0].changed.size(); ++i) {
    EXPECT_EQ(updates[0].changed[i].block, updates[1].changed[i].block);
    EXPECT_EQ(updates[0].changed[i].mesh->vertices, updates[1].changed[i].mesh->vertices);
    EXPECT_EQ(updates[0].changed[i].mesh->colors, updates[1].changed[i].mesh->colors);
  }
}

}  // namespace
}  // namespace tsg::mapping
