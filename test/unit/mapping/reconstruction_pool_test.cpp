// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/reconstruction_pool.h"

#include <gtest/gtest.h>

#include "synthetic_scene.h"

namespace tsg::mapping {
namespace {

struct SeenTrack {
  Track track;
  std::vector<SegmentedFrame> frames;
};

/// Balls of growing size in a row; ball i has label i + 1.
std::vector<SeenTrack> makeTracks(int count) {
  const CameraModel camera{80, 60, 65.0, 65.0, 39.5, 29.5};
  std::vector<SeenTrack> tracks;
  for (int i = 0; i < count; ++i) {
    const auto label = static_cast<std::uint16_t>(i + 1);
    const auto ball = test::makeSphere({0, 0, 0.5}, 0.15 + 0.01 * i, {200, 10, 10}, label);
    SeenTrack seen;
    seen.track.id = {static_cast<std::uint64_t>(100 + i)};
    for (int view = 0; view < 5; ++view) {
      const Eigen::Vector3d eye(std::cos(0.5 * view), std::sin(0.5 * view), 0.8);
      auto rendering = test::render({ball}, camera, test::lookAt(eye, {0, 0, 0.5}));
      rendering.frame.stamp = Stamp{1000 * i + view};
      auto segmentation = std::make_shared<Segmentation>();
      segmentation->stamp = rendering.frame.stamp;
      segmentation->labels = rendering.labels;
      seen.track.observations.push_back({rendering.frame.stamp, label});
      seen.frames.push_back({std::make_shared<RgbdFrame>(rendering.frame), segmentation});
    }
    tracks.push_back(std::move(seen));
  }
  return tracks;
}

TEST(ReconstructionPool, ResultsComeInOrderAndDoNotDependOnThreads) {
  const auto tracks = makeTracks(12);
  const ObjectReconstructor reconstructor({});
  for (const int threads : {1, 4}) {
    ReconstructionPool pool(reconstructor, threads, 3);
    for (const auto& seen : tracks) pool.submit(seen.track, seen.frames);
    const auto results = pool.collectAll();
    ASSERT_EQ(results.size(), tracks.size());
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      ASSERT_TRUE(results[i].result.primitive);
      const auto alone = reconstructor.reconstruct(tracks[i].track, tracks[i].frames, {1});
      EXPECT_EQ(results[i].result.primitive->track, tracks[i].track.id);
      EXPECT_EQ(results[i].result.primitive->mesh.vertices, alone.primitive->mesh.vertices);
      EXPECT_FALSE(results[i].result.primitive->id.isValid());
    }
    EXPECT_EQ(pool.numPending(), 0U);
    EXPECT_TRUE(pool.collectFinished().empty());
  }
}

TEST(ReconstructionPool, EveryResultIsTakenOnce) {
  const auto tracks = makeTracks(10);
  const ObjectReconstructor reconstructor({});
  ReconstructionPool pool(reconstructor, 2, 100);
  std::vector<TrackId> taken;
  const auto keep = [&](const std::vector<PooledResult>& results) {
    for (const auto& result : results) taken.push_back(result.track);
  };
  for (const auto& seen : tracks) {
    pool.submit(seen.track, seen.frames);
    keep(pool.collectFinished());
  }
  keep(pool.collectAll());
  ASSERT_EQ(taken.size(), tracks.size());
  for (std::size_t i = 0; i < tracks.size(); ++i) EXPECT_EQ(taken[i], tracks[i].track.id);
}

TEST(ReconstructionPool, BadFramesAreAResultNotAnEnd) {
  auto tracks = makeTracks(3);
  auto small = std::make_shared<Segmentation>();
  small->labels = cv::Mat::zeros(5, 5, CV_16UC1);
  tracks[1].frames[2].segmentation = small;
  tracks[2].frames.pop_back();
  const ObjectReconstructor reconstructor({});
  ReconstructionPool pool(reconstructor, 2, 100);
  for (const auto& seen : tracks) pool.submit(seen.track, seen.frames);
  const auto results = pool.collectAll();
  ASSERT_EQ(results.size(), 3U);
  EXPECT_EQ(results[0].result.status, ReconstructionStatus::kReconstructed);
  EXPECT_EQ(results[1].result.status, ReconstructionStatus::kBadFrames);
  EXPECT_EQ(results[2].result.status, ReconstructionStatus::kBadFrames);
}

TEST(ReconstructionPool, FramesAreLetGoOnceReconstructed) {
  auto tracks = makeTracks(1);
  const std::weak_ptr<const RgbdFrame> frame = tracks[0].frames[0].frame;
  const ObjectReconstructor reconstructor({});
  ReconstructionPool pool(reconstructor, 1, 100);
  pool.submit(std::move(tracks[0].track), std::move(tracks[0].frames));
  pool.collectAll();
  EXPECT_TRUE(frame.expired());
}

TEST(ReconstructionPool, EndsWithWorkLeft) {
  const auto tracks = makeTracks(8);
  const ObjectReconstructor reconstructor({});
  std::vector<std::weak_ptr<const RgbdFrame>> frames;
  {
    ReconstructionPool pool(reconstructor, 2, 100);
    for (const auto& seen : tracks) {
      std::vector<SegmentedFrame> copies;
      for (const auto& view : seen.frames) {
        const auto copy = std::make_shared<const RgbdFrame>(*view.frame);
        frames.push_back(copy);
        copies.push_back({copy, view.segmentation});
      }
      pool.submit(seen.track, std::move(copies));
    }
  }
  for (const auto& frame : frames) EXPECT_TRUE(frame.expired());
}

}  // namespace
}  // namespace tsg::mapping
