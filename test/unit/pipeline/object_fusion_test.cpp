// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/pipeline/object_fusion.h"

#include <gtest/gtest.h>

#include "synthetic_scene.h"
#include "task_scene_graph/config/config.h"

namespace tsg::pipeline {
namespace {

constexpr int kViews = 6;

/// Two balls seen from all round; track i + 1 is the ball with label i + 1; both end at the last
/// frame, and with them a track that was seen once only.
struct Walk {
  std::vector<RgbdFramePtr> frames;
  std::vector<SegmentationPtr> segmentations;
  TrackedFrame end;
};

Walk makeWalk() {
  const CameraModel camera{80, 60, 65.0, 65.0, 39.5, 29.5};
  const std::vector<test::Solid> scene{test::makeSphere({0, 0.3, 0.5}, 0.2, {200, 10, 10}, 1),
                                       test::makeSphere({0, -0.3, 0.5}, 0.2, {10, 200, 10}, 2)};
  Walk walk;
  for (std::uint64_t id = 1; id <= 3; ++id) {
    Track track;
    track.id = {id};
    walk.end.finished.push_back(track);
  }
  for (int i = 0; i < kViews; ++i) {
    const Eigen::Vector3d eye(1.5 * std::cos(0.2 * i), 1.5 * std::sin(0.2 * i), 0.8);
    auto rendering = test::render(scene, camera, test::lookAt(eye, {0, 0, 0.5}));
    rendering.frame.stamp = Stamp{1 + i};
    auto segmentation = std::make_shared<Segmentation>();
    segmentation->stamp = rendering.frame.stamp;
    segmentation->labels = rendering.labels;
    walk.frames.push_back(std::make_shared<RgbdFrame>(rendering.frame));
    walk.segmentations.push_back(segmentation);
    walk.end.stamp = rendering.frame.stamp;
    for (std::uint16_t label = 1; label <= 2; ++label) {
      walk.end.finished[label - 1U].observations.push_back({rendering.frame.stamp, label});
    }
  }
  walk.end.finished[2].observations.push_back({Stamp{1}, 1});
  return walk;
}

TrackedFrame makeLive(Stamp stamp) { return {stamp, {{1}, {2}}, {{1}, {2}}, {}}; }

void show(const Walk& walk, ObjectFusion& fusion) {
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    fusion.addFrame(walk.frames[i], walk.segmentations[i]);
    fusion.submitTracks(makeLive(walk.frames[i]->stamp));
  }
}

TEST(ObjectFusion, EndedTracksBecomePrimitivesInTheirOrder) {
  const Walk walk = makeWalk();
  std::vector<ObjectPrimitivePtr> before;
  for (const int threads : {1, 3}) {
    ObjectFusionConfig config;
    config.object_threads = threads;
    ObjectFusion fusion(config);
    show(walk, fusion);
    EXPECT_EQ(fusion.frames().counters().frames, static_cast<std::size_t>(kViews));
    const auto primitives = fusion.addTracks(walk.end);
    ASSERT_EQ(primitives.size(), 2U);
    EXPECT_EQ(primitives[0]->id, PrimitiveId{1});
    EXPECT_EQ(primitives[0]->track, TrackId{1});
    EXPECT_EQ(primitives[1]->id, PrimitiveId{2});
    EXPECT_EQ(primitives[1]->track, TrackId{2});
    EXPECT_EQ(fusion.rejections().at("too few observations"), 1U);
    EXPECT_EQ(fusion.frames().counters().frames, 0U);
    EXPECT_EQ(fusion.numPending(), 0U);
    if (!before.empty()) {
      EXPECT_EQ(primitives[1]->mesh.vertices, before[1]->mesh.vertices);
    }
    before = primitives;
  }
}

TEST(ObjectFusion, SubmittedTracksOutliveTheirFramesInTheBuffer) {
  const Walk walk = makeWalk();
  ObjectFusion fusion({});
  show(walk, fusion);
  fusion.submitTracks(walk.end);
  EXPECT_EQ(fusion.frames().counters().frames, 0U);
  const auto primitives = fusion.takePrimitives(true);
  EXPECT_EQ(primitives.size(), 2U);
  EXPECT_TRUE(fusion.takePrimitives(true).empty());
}

TEST(ObjectFusion, BadConfigurationIsRejected) {
  ObjectFusionConfig config;
  config.max_pending_tracks = 0;
  EXPECT_THROW(ObjectFusion fusion(config), config::ConfigError);
}

}  // namespace
}  // namespace tsg::pipeline
