// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/thin_surfaces.h"

#include <gtest/gtest.h>

#include <cmath>

#include "synthetic_scene.h"
#include "task_scene_graph/mapping/background_map.h"

namespace tsg::mapping {
namespace {

const CameraModel kCamera{320, 240, 262.0, 262.0, 159.5, 119.5};
const Eigen::Vector3d kEye{0.0, 0.0, 1.2};

/// A post of 3 cm at x = 2 m between the centres of two voxels, floor, and a wall 2 m behind.
const Eigen::AlignedBox3d kPost{Eigen::Vector3d(1.985, -0.015, 0.0),
                                Eigen::Vector3d(2.015, 0.015, 2.0)};

std::vector<test::Solid> makeRoom() {
  return {test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90}),
          test::makePlane({4, 0, 0}, {-1, 0, 0}, {10, 200, 30})};
}

std::vector<test::Solid> makeRoomWithPost() {
  auto scene = makeRoom();
  scene.push_back(test::makeBox(kPost, {200, 0, 0}));
  return scene;
}

IntegratorConfig makeConfig() {
  IntegratorConfig config;
  config.voxel_size_m = 0.1;
  config.truncation_m = 0.3;
  config.carve_free_space = true;
  config.with_color = false;
  return config;
}

/// A map as places are made of, and what was handed out of it so far.
class Carver {
 public:
  Carver() : map_(makeMapConfig()) {}

  void look(const std::vector<test::Solid>& scene, const Eigen::Vector3d& eye,
            const Eigen::Vector3d& target, int frames = 1) {
    for (int i = 0; i < frames; ++i) {
      auto frame = test::render(scene, kCamera, test::lookAt(eye, target)).frame;
      frame.stamp = Stamp::fromSeconds(0.1 * ++num_frames_);
      map_.integrate(frame);
    }
    const TsdfVolume changed = map_.takeChangedBlocks();
    for (const GridIndex& index : changed.sortedBlockIndices()) {
      taken_.allocateBlock(index) = *changed.findBlock(index);
    }
  }

  const TsdfVolume& carved() const { return map_.volume(); }
  const TsdfVolume& taken() const { return taken_; }
  BackgroundMap& map() { return map_; }

  /// Voxels that are free in the map and were handed out as solid.
  std::vector<Eigen::Vector3d> findMarked() const {
    std::vector<Eigen::Vector3d> marked_m;
    for (const GridIndex& index : taken_.sortedBlockIndices()) {
      const TsdfBlock* block = map_.volume().findBlock(index);
      for (int i = 0; block != nullptr && i < kBlockVoxels; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const float taken_m = taken_.findBlock(index)->voxels[at].distance_m;
        if (block->voxels[at].distance_m <= 0.0F || taken_m > 0.0F) continue;
        const GridIndex local(i % 8, i / 8 % 8, i / 64);
        marked_m.push_back(taken_.computeVoxelCenter(index * kBlockSide + local));
      }
    }
    return marked_m;
  }

 private:
  static BackgroundConfig makeMapConfig() {
    BackgroundConfig config;
    config.tsdf = makeConfig();
    config.with_mesh = false;
    config.archive_blocks = false;
    return config;
  }

  BackgroundMap map_;
  TsdfVolume taken_{0.1};
  int num_frames_ = 0;
};

TEST(ThinSurfaces, PostBetweenTheCentresOfVoxelsIsSolidAlongItsLength) {
  Carver carver;
  carver.look(makeRoomWithPost(), kEye, {2.0, 0.0, 1.0}, 3);
  for (double z_m = 0.35; z_m < 1.2; z_m += 0.1) {
    bool is_carved = true;
    bool is_marked = false;
    for (const double x_m : {1.95, 2.05}) {
      for (const double y_m : {-0.05, 0.05}) {
        const GridIndex voxel = carver.carved().computeVoxelIndex({x_m, y_m, z_m});
        is_carved = is_carved && carver.carved().findVoxel(voxel)->distance_m > 0.0F;
        is_marked = is_marked || carver.taken().findVoxel(voxel)->distance_m <= 0.0F;
      }
    }
    EXPECT_TRUE(is_carved) << z_m;
    EXPECT_TRUE(is_marked) << z_m;
  }
}

TEST(ThinSurfaces, OnlyVoxelsThatASurfaceCrossesAreMarked) {
  Carver carver;
  carver.look(makeRoomWithPost(), kEye, {2.0, 0.0, 1.0}, 3);
  const auto marked_m = carver.findMarked();
  EXPECT_GE(marked_m.size(), 8U);
  for (const auto& p_m : marked_m) {
    const double away_m = std::abs(test::computeSceneDistance(makeRoomWithPost(), p_m));
    EXPECT_LE(away_m, 0.5 * std::sqrt(3.0) * 0.1 + 1e-6) << p_m.transpose();
  }
}

TEST(ThinSurfaces, FloorsAndWallsUnderAnyAngleAreLeftToTheTsdf) {
  for (const double yaw : {0.0, 0.4, 0.8, 1.1, 1.3}) {
    const Eigen::Vector3d normal(-std::cos(yaw), std::sin(yaw), 0.0);
    const std::vector<test::Solid> scene{test::makePlane({0, 0, 0.02}, {0, 0, 1}, {90, 90, 90}),
                                         test::makePlane({2.03, 0.0, 0.0}, normal, {10, 200, 30})};
    Carver carver;
    carver.look(scene, kEye, {2.0, 0.0, 0.7}, 2);
    carver.look(scene, {0.4, 0.1, 1.2}, {2.2, 0.1, 0.8}, 2);
    EXPECT_TRUE(carver.findMarked().empty()) << yaw;
  }
}

TEST(ThinSurfaces, WhatWentAwayIsForgottenOnceItsPlaceWasSeenFreeAsOften) {
  Carver carver;
  carver.look(makeRoomWithPost(), kEye, {2.0, 0.0, 1.0}, 3);
  ASSERT_FALSE(carver.findMarked().empty());
  carver.look(makeRoom(), kEye, {2.0, 0.0, 1.0}, 2);
  EXPECT_FALSE(carver.findMarked().empty());
  carver.look(makeRoom(), kEye, {2.0, 0.0, 1.0}, 2);
  EXPECT_TRUE(carver.findMarked().empty());
}

TEST(ThinSurfaces, OneReadingInAFrameIsNoSurface) {
  auto frame = test::render(makeRoom(), kCamera, test::lookAt(kEye, {4.0, 0.0, 1.0})).frame;
  frame.depth.image.at<float>(120, 160) = 2.0F;
  TsdfVolume volume(0.1);
  TsdfIntegrator integrator(makeConfig());
  ThinSurfaces thin(makeConfig());
  const auto result = integrator.integrate(frame, volume);
  thin.add(frame, volume, result.observed_blocks);
  const Eigen::Vector3d p_m = frame.T_world_camera * frame.camera.unproject(160, 120, 2.0);
  const GridIndex voxel = volume.computeVoxelIndex(p_m);
  TsdfBlock copy = *volume.findBlock(TsdfVolume::computeBlockIndex(voxel));
  const TsdfBlock before = copy;
  thin.mark(volume, copy);
  for (std::size_t i = 0; i < copy.voxels.size(); ++i) {
    EXPECT_EQ(copy.voxels[i].distance_m, before.voxels[i].distance_m);
  }
}

TEST(ThinSurfaces, ArchivedBlocksBeginAnew) {
  Carver carver;
  carver.look(makeRoomWithPost(), kEye, {2.0, 0.0, 1.0}, 3);
  ASSERT_FALSE(carver.findMarked().empty());
  carver.map().archive(carver.carved().sortedBlockIndices());
  carver.look(makeRoom(), kEye, {2.0, 0.0, 1.0});
  EXPECT_TRUE(carver.findMarked().empty());
}

TEST(ThinSurfaces, MapsWithAMeshAreHandedOutAsTheyAre) {
  BackgroundConfig config;
  config.tsdf = makeConfig();
  BackgroundMap map(config);
  map.integrate(
      test::render(makeRoomWithPost(), kCamera, test::lookAt(kEye, {2.0, 0.0, 1.0})).frame);
  const TsdfVolume taken = map.takeChangedBlocks();
  ASSERT_FALSE(taken.blocks().empty());
  for (const GridIndex& index : taken.sortedBlockIndices()) {
    for (std::size_t i = 0; i < 512; ++i) {
      EXPECT_EQ(taken.findBlock(index)->voxels[i].distance_m,
                map.volume().findBlock(index)->voxels[i].distance_m);
    }
  }
}

}  // namespace
}  // namespace tsg::mapping
