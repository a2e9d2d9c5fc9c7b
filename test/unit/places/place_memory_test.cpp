// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/place_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "box_world.h"
#include "sparse_config.h"
#include "task_scene_graph/places/move_memory.h"
#include "task_scene_graph/places/place_extractor.h"

namespace tsg::places {
namespace {

using test::kVoxel_m;

const Aabb kWest = makeAabb({-0.5, -0.5, -0.5}, {4.6, 4.5, 2.4});
const Aabb kEast = makeAabb({3.5, -0.5, -0.5}, {8.8, 4.5, 2.4});
const Aabb kAll = makeAabb({-0.5, -0.5, -0.5}, {8.8, 4.5, 2.4});

/// Two rooms of 4 x 4 m with a door of 1 m between them.
test::BoxWorld makeWorld() {
  test::BoxWorld world;
  world.addRoom(0, 0, 8.2, 4);
  world.add({4.0, 0, 0}, {4.2, 1.5, 2.5}).add({4.0, 2.5, 0}, {4.2, 4, 2.5});
  return world.add({1.0, 2.6, 0}, {1.6, 3.2, 0.9});
}

/// The robot walks along y = 2 and sees what is in the box.
void look(PlaceExtractor& extractor, const Aabb& seen, double from_m, double to_m, double at_s) {
  mapping::TsdfVolume volume(kVoxel_m);
  const auto blocks = test::observe(makeWorld(), seen, volume);
  for (int i = 0; i <= 20; ++i) {
    CameraPose pose;
    pose.stamp = Stamp::fromSeconds(at_s + 0.1 * i);
    pose.T_world_camera.translation() =
        Eigen::Vector3d(from_m + (to_m - from_m) * i / 20.0, 2.0, 0.9);
    extractor.addPose(pose);
  }
  extractor.update(volume, blocks, Stamp::fromSeconds(at_s + 2.0));
}

/// A view of 80 x 60 px with depth 3 m everywhere, to the east from a position.
void addView(PlaceExtractor& extractor, const Eigen::Vector3d& from_m, int axis) {
  RgbdFrame frame;
  frame.camera = {80, 60, 60.0, 60.0, 39.5, 29.5};
  frame.T_world_camera.linear().col(0) = -Eigen::Vector3d::UnitY();
  frame.T_world_camera.linear().col(1) = -Eigen::Vector3d::UnitZ();
  frame.T_world_camera.linear().col(2) = Eigen::Vector3d::UnitX();
  frame.T_world_camera.translation() = from_m;
  frame.depth.image = cv::Mat(60, 80, CV_16UC1, cv::Scalar(3000));
  extractor.addView(frame, Embedding::Unit(4, axis));
}

void expectSame(const PlaceGraph& a, const PlaceGraph& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  ASSERT_EQ(a.places.size(), b.places.size());
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    EXPECT_EQ(a.places[i].id, b.places[i].id);
    EXPECT_EQ(a.places[i].position_m, b.places[i].position_m);
    EXPECT_EQ(a.places[i].clearance_m, b.places[i].clearance_m);
    EXPECT_EQ(a.places[i].num_views, b.places[i].num_views);
    ASSERT_EQ(a.places[i].embedding.size(), b.places[i].embedding.size());
    EXPECT_EQ(a.places[i].embedding, b.places[i].embedding);
  }
  ASSERT_EQ(a.edges.size(), b.edges.size());
  for (std::size_t i = 0; i < a.edges.size(); ++i) {
    EXPECT_EQ(a.edges[i].a, b.edges[i].a);
    EXPECT_EQ(a.edges[i].b, b.edges[i].b);
    EXPECT_EQ(a.edges[i].clearance_m, b.edges[i].clearance_m);
  }
}

TEST(PlaceMemory, ARestoredExtractorHasTheSameGraphAndGoesOnAsTheOneBefore) {
  PlaceExtractor first(makeSparseConfig());
  look(first, kWest, 0.5, 3.8, 1.0);
  addView(first, {0.5, 2.0, 0.9}, 0);
  ASSERT_GT(first.graph().places.size(), 5U);
  PlaceExtractor second(makeSparseConfig());
  second.restore(first.memory(), kVoxel_m);
  expectSame(first.graph(), second.graph());
  EXPECT_EQ(first.plan().tiles().size(), second.plan().tiles().size());
  for (PlaceExtractor* extractor : {&first, &second}) {
    look(*extractor, kEast, 3.8, 7.5, 4.0);
    addView(*extractor, {4.5, 2.0, 0.9}, 1);
  }
  EXPECT_GT(first.graph().places.size(), 10U);
  expectSame(first.graph(), second.graph());
}

TEST(PlaceMemory, NothingIsRememberedOfNothing) {
  PlaceExtractor extractor(makeSparseConfig());
  EXPECT_TRUE(extractor.memory().isEmpty());
  look(extractor, kWest, 0.5, 3.8, 1.0);
  extractor.restore(PlaceMemory(), kVoxel_m);
  EXPECT_TRUE(extractor.graph().places.empty());
  look(extractor, kWest, 0.5, 3.8, 1.0);
  EXPECT_FALSE(extractor.graph().places.empty());
}

TEST(PlaceMemory, AnotherVoxelSizeIsRefusedAndNothingChanges) {
  PlaceExtractor first(makeSparseConfig());
  look(first, kWest, 0.5, 3.8, 1.0);
  PlaceExtractor second(makeSparseConfig());
  look(second, kEast, 4.5, 7.5, 1.0);
  const PlaceGraph before = second.graph();
  EXPECT_THROW(second.restore(first.memory(), 0.2), std::invalid_argument);
  expectSame(before, second.graph());
}

TEST(PlaceMemory, TwoHalvesAreTheWhole) {
  PlaceExtractor whole(makeSparseConfig());
  look(whole, kAll, 0.5, 7.5, 1.0);
  PlaceExtractor west(makeSparseConfig());
  PlaceExtractor east(makeSparseConfig());
  look(west, kWest, 0.5, 4.1, 1.0);
  look(east, kEast, 4.1, 7.5, 1.0);
  PlaceExtractor both(makeSparseConfig());
  both.restore(mergeMemories(west.memory(), east.memory(), Pose::Identity(), 1000), kVoxel_m);
  const PlaceMemory expected = whole.memory();
  const PlaceMemory merged = both.memory();
  std::size_t num_observed = 0;
  std::size_t num_different = 0;
  VoxelMap voxels;
  voxels.restore(kVoxel_m, merged.blocks);
  for (const VoxelBlock& block : expected.blocks) {
    for (int i = 0; i < mapping::kBlockVoxels; ++i) {
      const float distance_m = block.distances_m[static_cast<std::size_t>(i)];
      if (isNotObserved(distance_m)) continue;
      const GridIndex voxel =
          block.index * mapping::kBlockSide + GridIndex(i % 8, i / 8 % 8, i / 64);
      ++num_observed;
      num_different += voxels.at(voxel) == distance_m ? 0 : 1;
    }
  }
  EXPECT_GT(num_observed, 10000U);
  EXPECT_EQ(num_different, 0U);
  EXPECT_EQ(both.graph().places.size(), whole.graph().places.size());
}

TEST(PlaceMemory, PlacesOfTheFirstKeepTheirIdsAndThoseOfTheSecondGetThemWithTheOffset) {
  PlaceExtractor west(makeSparseConfig());
  PlaceExtractor east(makeSparseConfig());
  look(west, kWest, 0.5, 4.1, 1.0);
  look(east, kEast, 4.1, 7.5, 1.0);
  PlaceExtractor both(makeSparseConfig());
  both.restore(mergeMemories(west.memory(), east.memory(), Pose::Identity(), 1000), kVoxel_m);
  std::size_t num_west = 0;
  std::size_t num_east = 0;
  for (const Place& place : both.graph().places) {
    (place.id.value < 1000 ? num_west : num_east) += 1;
    // Both halves have seen the seam, from 4.1 m where the second begins.
    const bool is_seam = place.position_m.x() > 4.1 && place.position_m.x() < 4.6;
    if (is_seam) continue;
    EXPECT_EQ(place.id.value < 1000, place.position_m.x() < 4.6) << place.position_m.transpose();
  }
  EXPECT_GT(num_west, 4U);
  EXPECT_GT(num_east, 4U);
}

TEST(PlaceMemory, AHalfInOtherCoordinatesFits) {
  // The eastern half as a robot has it whose map is turned by 90 degrees and lies elsewhere: voxels
  // fall on voxels, so the merged ones are exact.
  Pose T_b_a = Pose::Identity();
  T_b_a.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_b_a.translation() = Eigen::Vector3d(10.0, -20.0, 1.0);
  PlaceExtractor east(makeSparseConfig());
  look(east, kEast, 4.1, 7.5, 1.0);
  const PlaceMemory elsewhere = mergeMemories(PlaceMemory(), east.memory(), T_b_a, 0);
  const PlaceMemory back = mergeMemories(PlaceMemory(), elsewhere, T_b_a.inverse(), 0);
  PlaceExtractor returned(makeSparseConfig());
  returned.restore(back, kVoxel_m);
  const PlaceGraph expected = east.graph();
  const PlaceGraph found = returned.graph();
  ASSERT_EQ(found.places.size(), expected.places.size());
  for (std::size_t i = 0; i < expected.places.size(); ++i) {
    EXPECT_EQ(found.places[i].id, expected.places[i].id);
    EXPECT_LT((found.places[i].position_m - expected.places[i].position_m).norm(), 0.3);
  }
}

TEST(PlaceMemory, DifferentVoxelsCannotBeMerged) {
  PlaceMemory a;
  a.voxel_size_m = 0.1;
  PlaceMemory b;
  b.voxel_size_m = 0.2;
  EXPECT_THROW(mergeMemories(a, b, Pose::Identity(), 0), std::invalid_argument);
}

void expectSameBlocks(const PlaceMemory& a, const PlaceMemory& b) {
  ASSERT_EQ(a.blocks.size(), b.blocks.size());
  for (std::size_t i = 0; i < a.blocks.size(); ++i) {
    ASSERT_EQ(a.blocks[i].index, b.blocks[i].index);
    for (std::size_t k = 0; k < a.blocks[i].distances_m.size(); ++k) {
      const float x_m = a.blocks[i].distances_m[k];
      const float y_m = b.blocks[i].distances_m[k];
      ASSERT_TRUE(x_m == y_m || (isNotObserved(x_m) && isNotObserved(y_m)));
    }
  }
}

TEST(PlaceMemory, MovedAsAWholeItIsInOtherCoordinates) {
  PlaceExtractor east(makeSparseConfig());
  look(east, kEast, 4.1, 7.5, 1.0);
  addView(east, {5.0, 2.0, 1.2}, 1);
  const PlaceMemory memory = east.memory();
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(10.0, -20.0, 1.0);
  const PlaceMemory moved = moveMemory(memory, [&](const Eigen::Vector3d&) { return T; });
  const PlaceMemory expected = mergeMemories(PlaceMemory(), memory, T, 0);
  expectSameBlocks(moved, expected);
  ASSERT_EQ(moved.way.segments.size(), memory.way.segments.size());
  EXPECT_TRUE(moved.way.segments[0].to_m.isApprox(expected.way.segments[0].to_m));
  EXPECT_TRUE(moved.way.last->T_world_camera.isApprox(T * memory.way.last->T_world_camera));
  ASSERT_EQ(moved.views.size(), 1U);
  EXPECT_TRUE(moved.views[0].T_camera_world.isApprox(expected.views[0].T_camera_world));
  ASSERT_EQ(moved.places.size(), memory.places.size());
  for (std::size_t i = 0; i < moved.places.size(); ++i) {
    EXPECT_EQ(moved.places[i].place.id, memory.places[i].place.id);
    EXPECT_TRUE(moved.places[i].place.position_m.isApprox(T * memory.places[i].place.position_m));
    EXPECT_EQ(moved.places[i].key, expected.places[i].key);
  }
  EXPECT_EQ(moved.next_id, memory.next_id);
  EXPECT_EQ(moved.stamp, memory.stamp);
  EXPECT_TRUE(moved.plan.tiles().empty());
}

TEST(PlaceMemory, HalvesThatMoveApartEachMoveRigidly) {
  PlaceExtractor whole(makeSparseConfig());
  look(whole, kAll, 0.5, 7.5, 1.0);
  const PlaceMemory memory = whole.memory();
  PlaceMemory west = memory;
  PlaceMemory east = memory;
  const auto isEast = [](const VoxelBlock& block) { return block.index.x() >= 5; };
  const auto isWest = [&](const VoxelBlock& block) { return !isEast(block); };
  west.blocks.erase(std::remove_if(west.blocks.begin(), west.blocks.end(), isEast),
                    west.blocks.end());
  east.blocks.erase(std::remove_if(east.blocks.begin(), east.blocks.end(), isWest),
                    east.blocks.end());
  ASSERT_FALSE(west.blocks.empty());
  ASSERT_FALSE(east.blocks.empty());
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(40.0 * kVoxel_m, 3.0 * kVoxel_m, 0.0);
  const double border_m = 5.0 * mapping::kBlockSide * kVoxel_m;
  const PlaceMemory moved = moveMemory(memory, [&](const Eigen::Vector3d& p_m) {
    return p_m.x() > border_m ? T : Pose::Identity();
  });
  const PlaceMemory shifted = mergeMemories(PlaceMemory(), east, T, 0);
  expectSameBlocks(moved, mergeMemories(west, shifted, Pose::Identity(), 0));
}

}  // namespace
}  // namespace tsg::places
