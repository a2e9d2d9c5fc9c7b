// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "reference_tracker.h"
#include "task_scene_graph/tracking/tracker.h"

namespace tsg::tracking {
namespace {

/// Frames of a camera that wanders before a bumpy wall, cut into random rectangles; every fifth
/// segment has no embedding, the others look like one of four things.
class RandomWalk {
 public:
  explicit RandomWalk(unsigned seed) : random_(seed) {
    frame_.camera = {48, 36, 40.0, 40.0, 23.5, 17.5};
    segmentation_.confidences.assign(kSegments, 1.0F);
  }

  void step() {
    std::uniform_real_distribution<double> shift_m(-0.25, 0.25);
    std::uniform_real_distribution<double> pause_s(0.05, 1.5);
    std::uniform_int_distribution<int> depth_mm(1900, 2100);
    frame_.T_world_camera.translation() += Eigen::Vector3d(shift_m(random_), shift_m(random_), 0.0);
    stamp_s_ += pause_s(random_);
    frame_.stamp = segmentation_.stamp = Stamp::fromSeconds(stamp_s_);
    frame_.depth.image = cv::Mat(36, 48, CV_16UC1);
    for (int v = 0; v < 36; ++v) {
      for (int u = 0; u < 48; ++u) {
        frame_.depth.image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(depth_mm(random_));
      }
    }
    drawSegments();
  }

  const RgbdFrame& frame() const { return frame_; }
  const Segmentation& segmentation() const { return segmentation_; }

 private:
  static constexpr int kSegments = 8;

  void drawSegments() {
    std::uniform_int_distribution<int> jitter_px(0, 2);
    std::normal_distribution<float> noise(0.0F, 0.3F);
    segmentation_.labels = cv::Mat::zeros(36, 48, CV_16UC1);
    segmentation_.embeddings.setZero(kSegments, 4);
    std::vector<int> order(kSegments);
    for (int s = 0; s < kSegments; ++s) order[static_cast<std::size_t>(s)] = s;
    std::shuffle(order.begin(), order.end(), random_);
    for (int s = 0; s < kSegments; ++s) {
      const int cell = order[static_cast<std::size_t>(s)];
      const cv::Rect box(12 * (cell % 4) + jitter_px(random_), 18 * (cell / 4) + jitter_px(random_),
                         10, 15);
      segmentation_.labels(box).setTo(s + 1);
      if (cell % 5 == 0) continue;
      for (int d = 0; d < 4; ++d) segmentation_.embeddings(s, d) = noise(random_);
      segmentation_.embeddings(s, cell % 4) += 1.0F;
    }
  }

  std::mt19937 random_;
  RgbdFrame frame_;
  Segmentation segmentation_;
  double stamp_s_ = 0.0;
};

TrackerConfig looseConfig() {
  TrackerConfig config;
  config.min_cosine = 0.8;
  config.min_iou = 0.15;
  config.window_s = 3.0;
  config.min_observations = 1;
  return config;
}

std::vector<std::uint64_t> toValues(const std::vector<TrackId>& ids) {
  std::vector<std::uint64_t> values;
  for (const TrackId id : ids) values.push_back(id.value);
  return values;
}

void expectEqualTrack(const Track& track, const test::ReferenceTracker::Entry& expected) {
  EXPECT_EQ(track.first_seen, expected.first_seen);
  EXPECT_EQ(track.last_seen, expected.last_seen);
  ASSERT_EQ(track.observations.size(), expected.observations.size());
  for (std::size_t i = 0; i < track.observations.size(); ++i) {
    EXPECT_EQ(track.observations[i].stamp, expected.observations[i].stamp);
    EXPECT_EQ(track.observations[i].segment, expected.observations[i].segment);
  }
  const Embedding mean = test::ReferenceTracker::computeMean(expected);
  ASSERT_EQ(track.embedding.size(), mean.size());
  EXPECT_TRUE(mean.size() == 0 || track.embedding.isApprox(mean, 1e-5F));
}

class TrackerOracle : public testing::TestWithParam<unsigned> {};

TEST_P(TrackerOracle, AgreesWithAReferenceOnARandomWalk) {
  Tracker tracker{looseConfig()};
  test::ReferenceTracker reference{looseConfig()};
  RandomWalk walk(GetParam());
  std::size_t num_ended = 0;
  for (int i = 0; i < 60; ++i) {
    walk.step();
    const auto result = tracker.update(walk.frame(), walk.segmentation());
    ASSERT_EQ(toValues(result.segment_tracks), reference.update(walk.frame(), walk.segmentation()));
    ASSERT_EQ(result.live.size(), reference.live.size());
    num_ended += result.finished.size();
    for (const Track& track : result.finished) {
      ASSERT_EQ(reference.ended.count(track.id.value), 1U);
      expectEqualTrack(track, reference.ended.at(track.id.value));
    }
  }
  EXPECT_EQ(num_ended, reference.ended.size());
  EXPECT_GT(num_ended, 10U);
  EXPECT_GT(tracker.counters().associations, 50U);
}

INSTANTIATE_TEST_SUITE_P(Seeds, TrackerOracle, testing::Range(1U, 9U));

TEST(TrackerProperties, NoTrackTwiceInAFrameAndNoObservationLost) {
  Tracker tracker{looseConfig()};
  RandomWalk walk(99);
  std::size_t assigned = 0;
  std::size_t observed = 0;
  for (int i = 0; i < 100; ++i) {
    walk.step();
    auto result = tracker.update(walk.frame(), walk.segmentation());
    for (const Track& track : result.finished) observed += track.observations.size();
    assigned += result.segment_tracks.size();
    std::sort(result.segment_tracks.begin(), result.segment_tracks.end());
    ASSERT_TRUE(result.segment_tracks.front().isValid());
    ASSERT_EQ(std::adjacent_find(result.segment_tracks.begin(), result.segment_tracks.end()),
              result.segment_tracks.end());
  }
  for (const Track& track : tracker.finish().finished) observed += track.observations.size();
  EXPECT_EQ(observed, assigned);
}

TEST(TrackerProperties, SameFramesGiveTheSameTracks) {
  std::vector<std::vector<std::uint64_t>> runs[2];
  for (auto& run : runs) {
    Tracker tracker{looseConfig()};
    RandomWalk walk(4);
    for (int i = 0; i < 40; ++i) {
      walk.step();
      run.push_back(toValues(tracker.update(walk.frame(), walk.segmentation()).segment_tracks));
    }
  }
  EXPECT_EQ(runs[0], runs[1]);
}

}  // namespace
}  // namespace tsg::tracking
