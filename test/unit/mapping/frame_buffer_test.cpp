// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/frame_buffer.h"

#include <gtest/gtest.h>

#include "task_scene_graph/config/config.h"

namespace tsg::mapping {
namespace {

constexpr std::size_t kFrameBytes = 400 * 500 * 5;  // colour and 16-bit depth: 1 MB
constexpr std::size_t kLabelBytes = 400 * 500 * 2;

RgbdFramePtr makeFrame(std::int64_t ns) {
  auto frame = std::make_shared<RgbdFrame>();
  frame->stamp = {ns};
  frame->color.image = cv::Mat(400, 500, CV_8UC3);
  frame->depth.image = cv::Mat(400, 500, CV_16UC1);
  return frame;
}

SegmentationPtr makeSegmentation(std::int64_t ns) {
  auto segmentation = std::make_shared<Segmentation>();
  segmentation->stamp = {ns};
  segmentation->labels = cv::Mat(400, 500, CV_16UC1);
  return segmentation;
}

TrackedFrame makeTracked(std::int64_t ns, const std::vector<TrackId>& seen,
                         const std::vector<TrackId>& live) {
  TrackedFrame tracked;
  tracked.stamp = {ns};
  tracked.segment_tracks = seen;
  tracked.live = live;
  return tracked;
}

TEST(FrameBuffer, KeepsWhatLiveTracksSawAndNothingElse) {
  FrameBuffer buffer({});
  for (std::int64_t ns = 1; ns <= 3; ++ns) buffer.add(makeFrame(ns), makeSegmentation(ns));
  buffer.update(makeTracked(1, {{1}, {0}}, {{1}}));
  buffer.update(makeTracked(2, {}, {{1}}));
  buffer.update(makeTracked(3, {{1}, {2}}, {{1}, {2}}));
  EXPECT_TRUE(buffer.find({1}).frame);
  EXPECT_FALSE(buffer.find({2}).frame);
  EXPECT_TRUE(buffer.find({3}).frame);
  buffer.add(makeFrame(4), makeSegmentation(4));
  buffer.update(makeTracked(4, {{2}}, {{2}}));  // track 1 has ended
  EXPECT_FALSE(buffer.find({1}).frame);
  EXPECT_TRUE(buffer.find({3}).frame);
  buffer.update(makeTracked(5, {}, {}));
  EXPECT_EQ(buffer.counters().frames, 0U);
  EXPECT_EQ(buffer.counters().bytes, 0U);
  EXPECT_EQ(buffer.counters().released, 4U);
}

TEST(FrameBuffer, FramesAreSharedNotCopied) {
  FrameBuffer buffer({});
  const auto frame = makeFrame(1);
  const auto segmentation = makeSegmentation(1);
  buffer.add(frame, segmentation);
  EXPECT_EQ(buffer.find({1}).frame, frame);
  EXPECT_EQ(buffer.find({1}).segmentation, segmentation);
  EXPECT_EQ(buffer.counters().bytes, kFrameBytes + kLabelBytes);
}

TEST(FrameBuffer, FramesMoveWithoutACopyOfTheirPixelsAndAreCountedOnce) {
  FrameBuffer buffer({});
  buffer.add(makeFrame(1), makeSegmentation(1));
  buffer.addFrame(makeFrame(2));
  const RgbdFramePtr before = buffer.find({1}).frame;
  const std::size_t alive = buffer.aliveBytes();
  buffer.moveFrames([](Stamp stamp) {
    Pose motion = Pose::Identity();
    motion.translation().x() = static_cast<double>(stamp.ns);
    return motion;
  });
  for (const std::int64_t ns : {1, 2}) {
    const RgbdFramePtr moved = buffer.find({ns}).frame;
    EXPECT_EQ(moved->T_world_camera.translation().x(), static_cast<double>(ns));
  }
  EXPECT_EQ(buffer.find({1}).frame->depth.image.data, before->depth.image.data);
  EXPECT_EQ(buffer.find({1}).segmentation->stamp, Stamp{1});
  EXPECT_EQ(before->T_world_camera.translation().x(), 0.0);  // whoever has it has it as it was
  EXPECT_EQ(buffer.counters().bytes, 2 * kFrameBytes + kLabelBytes);
  EXPECT_GT(buffer.aliveBytes(), alive);  // as long as somebody has the one of before
}

TEST(FrameBuffer, FramesNotYetSegmentedWaitUntilALaterOneIsTracked) {
  FrameBuffer buffer({});
  for (std::int64_t ns = 1; ns <= 5; ++ns) buffer.addFrame(makeFrame(ns));
  buffer.addSegmentation(makeSegmentation(3));
  buffer.update(makeTracked(3, {{1}}, {{1}}));
  EXPECT_EQ(buffer.counters().frames, 3U);
  EXPECT_FALSE(buffer.find({2}).frame);
  EXPECT_TRUE(buffer.find({3}).segmentation);
  EXPECT_TRUE(buffer.find({4}).frame);
  EXPECT_FALSE(buffer.find({4}).segmentation);
}

TEST(FrameBuffer, BytesAreBoundedAndTheOldestFrameGoes) {
  FrameBufferConfig config;
  config.max_megabytes = 3;
  FrameBuffer buffer(config);
  for (std::int64_t ns = 1; ns <= 10; ++ns) {
    buffer.add(makeFrame(ns), makeSegmentation(ns));
    EXPECT_LE(buffer.counters().bytes, 3000000U);
  }
  EXPECT_EQ(buffer.counters().frames, 2U);
  EXPECT_EQ(buffer.counters().evicted, 8U);
  EXPECT_EQ(buffer.counters().added, 10U);
  EXPECT_TRUE(buffer.find({10}).frame);
}

TEST(FrameBuffer, CollectsAFramePerObservationAndKeepsItAlive) {
  FrameBuffer buffer({});
  std::weak_ptr<const RgbdFrame> first;
  Track track;
  track.observations = {{{1}, 7}, {{2}, 7}, {{9}, 7}};
  std::vector<SegmentedFrame> frames;
  {
    const auto frame = makeFrame(1);
    first = frame;
    buffer.add(frame, makeSegmentation(1));
    buffer.add(makeFrame(2), makeSegmentation(2));
    frames = buffer.collect(track);
  }
  buffer.update(makeTracked(3, {}, {}));
  EXPECT_EQ(buffer.counters().frames, 0U);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].frame, first.lock());
  EXPECT_TRUE(frames[1].segmentation);
  EXPECT_FALSE(frames[2].frame);
  frames.clear();
  EXPECT_TRUE(first.expired());
}

TEST(FrameBuffer, SegmentationsOfUnknownFramesAreCounted) {
  FrameBuffer buffer({});
  buffer.addSegmentation(makeSegmentation(1));
  EXPECT_EQ(buffer.counters().unknown_segmentations, 1U);
  EXPECT_EQ(buffer.counters().frames, 0U);
}

TEST(FrameBuffer, AFrameGivenTwiceCountsOnce) {
  FrameBuffer buffer({});
  buffer.add(makeFrame(1), makeSegmentation(1));
  buffer.add(makeFrame(1), makeSegmentation(1));
  EXPECT_EQ(buffer.counters().frames, 1U);
  EXPECT_EQ(buffer.counters().bytes, kFrameBytes + kLabelBytes);
}

TEST(FrameBuffer, BadBoundIsRejected) {
  FrameBufferConfig config;
  config.max_megabytes = 0;
  EXPECT_THROW(FrameBuffer buffer(config), config::ConfigError);
}

}  // namespace
}  // namespace tsg::mapping
