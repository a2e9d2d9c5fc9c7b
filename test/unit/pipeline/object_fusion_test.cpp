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
    EXPECT_EQ(fusion.frameCounters().frames, static_cast<std::size_t>(kViews));
    const auto primitives = fusion.addTracks(walk.end).primitives;
    ASSERT_EQ(primitives.size(), 2U);
    EXPECT_EQ(primitives[0]->id, PrimitiveId{1});
    EXPECT_EQ(primitives[0]->track, TrackId{1});
    EXPECT_EQ(primitives[1]->id, PrimitiveId{2});
    EXPECT_EQ(primitives[1]->track, TrackId{2});
    EXPECT_EQ(fusion.rejections().at("too few observations"), 1U);
    EXPECT_EQ(fusion.frameCounters().frames, 0U);
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
  EXPECT_EQ(fusion.frameCounters().frames, 0U);
  EXPECT_EQ(fusion.collect(true).primitives.size(), 2U);
  EXPECT_TRUE(fusion.collect(true).primitives.empty());
}

/// The walk's first track as the tracker describes it while it lives.
TrackedFrame describe(const Walk& walk, bool is_snapshot = false) {
  TrackedFrame tracked = makeLive(walk.end.stamp);
  tracked.provisional = {walk.end.finished[0]};
  tracked.is_snapshot = is_snapshot;
  return tracked;
}

TEST(ObjectFusion, ALiveTrackGivesAProvisionalPrimitiveThatTheFinalOneReplaces) {
  const Walk walk = makeWalk();
  ObjectFusion fusion({});
  show(walk, fusion);
  const auto provisional = fusion.addTracks(describe(walk)).primitives;
  ASSERT_EQ(provisional.size(), 1U);
  EXPECT_TRUE(provisional[0]->is_provisional);
  const auto update = fusion.addTracks(walk.end);
  ASSERT_EQ(update.primitives.size(), 2U);
  EXPECT_EQ(update.primitives[0]->id, provisional[0]->id);
  EXPECT_FALSE(update.primitives[0]->is_provisional);
  EXPECT_EQ(update.primitives[0]->mesh.vertices, provisional[0]->mesh.vertices);
  EXPECT_NE(update.primitives[1]->id, provisional[0]->id);
  EXPECT_TRUE(update.withdrawn.empty());
}

TEST(ObjectFusion, ProvisionalPrimitivesDoNotChangeTheFinalOnes) {
  const Walk walk = makeWalk();
  ObjectFusion without({});
  show(walk, without);
  const auto expected = without.addTracks(walk.end).primitives;
  ObjectFusion with({});
  show(walk, with);
  with.addTracks(describe(walk, true));
  const auto primitives = with.addTracks(walk.end).primitives;
  ASSERT_EQ(primitives.size(), expected.size());
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    EXPECT_EQ(primitives[i]->id, expected[i]->id);
    EXPECT_EQ(primitives[i]->mesh.vertices, expected[i]->mesh.vertices);
  }
}

TEST(ObjectFusion, WhatHasNotGrownIsNotReconstructedAgain) {
  const Walk walk = makeWalk();
  ObjectFusion fusion({});
  show(walk, fusion);
  EXPECT_EQ(fusion.addTracks(describe(walk, true)).primitives.size(), 1U);
  EXPECT_TRUE(fusion.addTracks(describe(walk, true)).primitives.empty());
}

TEST(ObjectFusion, AProvisionalPrimitiveOfATrackThatVanishedIsWithdrawn) {
  const Walk walk = makeWalk();
  ObjectFusion fusion({});
  show(walk, fusion);
  const auto provisional = fusion.addTracks(describe(walk)).primitives;
  ASSERT_EQ(provisional.size(), 1U);
  const auto update = fusion.addTracks({walk.end.stamp, {}, {{2}}, {}});
  EXPECT_EQ(update.withdrawn, std::vector<PrimitiveId>{provisional[0]->id});
}

TEST(ObjectFusion, AProvisionalPrimitiveIsWithdrawnIfTheEndedTrackGivesNone) {
  const Walk walk = makeWalk();
  ObjectFusion fusion({});
  show(walk, fusion);
  const auto provisional = fusion.addTracks(describe(walk)).primitives;
  ASSERT_EQ(provisional.size(), 1U);
  TrackedFrame end = walk.end;
  end.finished = {walk.end.finished[0]};
  end.finished[0].observations.resize(1);
  const auto update = fusion.addTracks(end);
  EXPECT_TRUE(update.primitives.empty());
  EXPECT_EQ(update.withdrawn, std::vector<PrimitiveId>{provisional[0]->id});
}

TEST(ObjectFusion, TracksOfAnEpochAreReconstructedFromItsOwnFrames) {
  const Walk walk = makeWalk();
  ObjectFusion fusion({});
  show(walk, fusion);
  // The clock jumps back: the same stamps once more, before the first pass' tracks have ended.
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    fusion.addFrame(walk.frames[i], walk.segmentations[i], 2);
  }
  fusion.submitTracks(walk.end, 1);
  EXPECT_EQ(fusion.collect(true).primitives.size(), 2U);
  EXPECT_EQ(fusion.frameCounters().frames, static_cast<std::size_t>(kViews));
  TrackedFrame second = walk.end;
  for (Track& track : second.finished) track.id.value += 10;
  for (const auto& frame : walk.frames) {
    TrackedFrame live = makeLive(frame->stamp);
    for (TrackId& id : live.segment_tracks) id.value += 10;
    for (TrackId& id : live.live) id.value += 10;
    fusion.submitTracks(live, 2);
  }
  fusion.submitTracks(second, 2);
  EXPECT_EQ(fusion.collect(true).primitives.size(), 2U);
  EXPECT_EQ(fusion.frameCounters().frames, 0U);
}

TEST(ObjectFusion, FramesOfWaitingTracksCountAgainstTheBound) {
  const Walk walk = makeWalk();
  ObjectFusionConfig config;
  config.object_threads = 1;
  config.frame_buffer.max_megabytes = 1;
  ObjectFusion fusion(config);
  std::size_t most = 0;
  for (std::uint64_t round = 0; round < 30; ++round) {
    TrackedFrame end = walk.end;
    for (Track& track : end.finished) track.id.value += 10 * round;
    for (std::size_t i = 0; i < walk.frames.size(); ++i) {
      auto copy = std::make_shared<RgbdFrame>(*walk.frames[i]);
      copy->color.image = copy->color.image.clone();
      copy->depth.image = copy->depth.image.clone();
      fusion.addFrame(copy, walk.segmentations[i], static_cast<std::uint32_t>(round + 1));
      most = std::max(most, fusion.aliveBytes());
    }
    fusion.submitTracks(end, static_cast<std::uint32_t>(round + 1));
  }
  EXPECT_LE(most, 1000000U + 1000000U / kViews);
  EXPECT_GT(most, 100000U);
  fusion.collect(true);
}

TEST(ObjectFusion, ResetForgetsFramesAndTracks) {
  const Walk walk = makeWalk();
  ObjectFusion fusion({});
  show(walk, fusion);
  fusion.addTracks(describe(walk));
  fusion.reset();
  EXPECT_EQ(fusion.aliveBytes(), 0U);
  EXPECT_EQ(fusion.addTracks(walk.end).primitives.size(), 0U);
  EXPECT_EQ(fusion.rejections().at("no frames"), 2U);
}

TEST(ObjectFusion, BadConfigurationIsRejected) {
  ObjectFusionConfig config;
  config.max_pending_tracks = 0;
  EXPECT_THROW(ObjectFusion fusion(config), config::ConfigError);
}

}  // namespace
}  // namespace tsg::pipeline
