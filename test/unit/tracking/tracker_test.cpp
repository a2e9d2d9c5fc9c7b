// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/tracking/tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "task_scene_graph/config/config.h"

namespace tsg::tracking {
namespace {

/// A wall seen head-on, 2 m away; at 100 px focal length a 0.1 m voxel spans 5 x 5 px. The
/// principal point makes voxel borders fall on pixel borders: voxel column i covers u = 5i .. 5i+4.
class WallCamera {
 public:
  WallCamera() {
    frame_.camera = {100, 50, 100.0, 100.0, -0.5, -0.5};
    frame_.depth.image = cv::Mat(50, 100, CV_16UC1, cv::Scalar(2000));
    frame_.T_world_camera.translation().z() = 0.05;
    segmentation_.labels = cv::Mat::zeros(50, 100, CV_16UC1);
  }

  /// Adds a segment: voxel columns [column, column + columns), rows [0, rows).
  WallCamera& add(int column, int columns, const Embedding& embedding = {}, int rows = 10) {
    const auto s = segmentation_.embeddings.rows();
    const Eigen::Index size = std::max(segmentation_.embeddings.cols(), embedding.size());
    segmentation_.embeddings.conservativeResize(s + 1, size);
    segmentation_.embeddings.row(s).setZero();
    if (embedding.size() > 0) segmentation_.embeddings.row(s) = embedding.transpose();
    segmentation_.confidences.push_back(1.0F);
    segmentation_.labels(cv::Rect(5 * column, 0, 5 * columns, 5 * rows))
        .setTo(static_cast<double>(s + 1));
    return *this;
  }

  WallCamera& at(double seconds) {
    frame_.stamp = segmentation_.stamp = Stamp::fromSeconds(seconds);
    return *this;
  }

  TrackedFrame giveTo(Tracker& tracker) const { return tracker.update(frame_, segmentation_); }

  RgbdFrame frame_;
  Segmentation segmentation_;
};

WallCamera wallAt(double seconds) {
  WallCamera wall;
  return wall.at(seconds);
}

Embedding makeEmbedding(std::initializer_list<float> values) {
  Embedding embedding(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), embedding.data());
  return embedding;
}

/// Unit vector whose cosine with (1, 0) is `cosine`.
Embedding embeddingWithCosine(double cosine) {
  return makeEmbedding(
      {static_cast<float>(cosine), static_cast<float>(std::sin(std::acos(cosine)))});
}

const Embedding kForward = makeEmbedding({1.0F, 0.0F});

TrackerConfig configWith(double min_cosine, double min_iou) {
  TrackerConfig config;
  config.min_cosine = min_cosine;
  config.min_iou = min_iou;
  return config;
}

TEST(TrackerConfig, PresetsAreThePapersAndKhronosThresholds) {
  TrackerConfig config;
  EXPECT_DOUBLE_EQ(resolveThresholds(config).min_cosine, 0.9);
  EXPECT_DOUBLE_EQ(resolveThresholds(config).min_iou, 0.6);
  config.preset = Preset::kKhronos;
  EXPECT_DOUBLE_EQ(resolveThresholds(config).min_cosine, 0.7);
  EXPECT_DOUBLE_EQ(resolveThresholds(config).min_iou, 0.4);
}

TEST(TrackerConfig, GivenThresholdsReplaceThePresets) {
  TrackerConfig config;
  config.min_iou = 0.25;
  EXPECT_DOUBLE_EQ(resolveThresholds(config).min_cosine, 0.9);
  EXPECT_DOUBLE_EQ(resolveThresholds(config).min_iou, 0.25);
}

TEST(TrackerConfig, ErrorNamesEveryFieldOutOfRange) {
  TrackerConfig config;
  config.window_s = -1.0;
  config.voxel_size_m = 0.0;
  try {
    Tracker tracker(config);
    FAIL() << "accepted";
  } catch (const config::ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("window_s"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("voxel_size_m"), std::string::npos);
  }
}

TEST(Tracker, SameSegmentKeepsItsTrack) {
  Tracker tracker{TrackerConfig{}};
  const auto first = wallAt(1.0).add(2, 5, kForward).giveTo(tracker);
  const auto second = wallAt(1.1).add(2, 5, kForward).giveTo(tracker);
  ASSERT_TRUE(first.segment_tracks[0].isValid());
  EXPECT_EQ(second.segment_tracks[0], first.segment_tracks[0]);
  EXPECT_EQ(second.live, std::vector<TrackId>{first.segment_tracks[0]});
  EXPECT_EQ(tracker.counters().associations, 1U);
  EXPECT_EQ(tracker.counters().tracks_started, 1U);
}

TEST(Tracker, IoUAtTheThresholdAssociatesAndJustBelowDoesNot) {
  // Columns 0..3 and 1..4 share 3 of 5: IoU 0.6.
  for (const double min_iou : {0.6, std::nextafter(0.6, 1.0)}) {
    Tracker tracker{configWith(0.9, min_iou)};
    const auto first = wallAt(1.0).add(0, 4, kForward).giveTo(tracker);
    const auto second = wallAt(1.1).add(1, 4, kForward).giveTo(tracker);
    EXPECT_EQ(second.segment_tracks[0] == first.segment_tracks[0], min_iou == 0.6);
  }
}

TEST(Tracker, SegmentsThatOnlyTheirCosineKeepsFromATrackAreCounted) {
  Tracker tracker{TrackerConfig{}};
  wallAt(1.0).add(0, 4, kForward).add(10, 4, kForward).giveTo(tracker);
  EXPECT_EQ(tracker.counters().overlapping_segments, 0U);
  wallAt(1.1).add(0, 4, embeddingWithCosine(0.7)).add(10, 4, kForward).giveTo(tracker);
  EXPECT_EQ(tracker.counters().overlapping_segments, 2U);
  EXPECT_EQ(tracker.counters().refused_by_cosine, 1U);
  EXPECT_EQ(tracker.counters().overlap_cosines.count(), 2U);
  EXPECT_NEAR(tracker.counters().overlap_cosines.quantile(0.25), 0.7, 0.01);
  EXPECT_NEAR(tracker.counters().overlap_cosines.quantile(1.0), 1.0, 0.01);
}

TEST(Tracker, SegmentsThatOverlapTooLittleOrHaveNoEmbeddingAreNotCountedAsRefused) {
  Tracker tracker{TrackerConfig{}};
  wallAt(1.0).add(0, 4, kForward).giveTo(tracker);
  wallAt(1.1).add(3, 4, embeddingWithCosine(0.1)).giveTo(tracker);
  wallAt(1.2).add(0, 4).giveTo(tracker);
  EXPECT_EQ(tracker.counters().overlapping_segments, 0U);
  EXPECT_EQ(tracker.counters().refused_by_cosine, 0U);
}

TEST(CosineHistogram, QuantilesAreThoseAddedToAHundredth) {
  CosineHistogram histogram;
  EXPECT_EQ(histogram.quantile(0.5), 0.0);
  for (int i = -100; i <= 100; ++i) histogram.add(0.01 * i);
  EXPECT_EQ(histogram.count(), 201U);
  EXPECT_NEAR(histogram.quantile(0.25), -0.5, 0.011);
  EXPECT_NEAR(histogram.quantile(0.5), 0.0, 0.011);
  EXPECT_NEAR(histogram.quantile(1.0), 1.0, 0.011);
}

double learnLimit(const std::function<double(int)>& makeCosine, int count,
                  double configured = 0.9) {
  ViewCosine learned;
  for (int i = 0; i < count; ++i) learned.add(makeCosine(i));
  return learned.computeLimit(configured);
}

TEST(ViewCosine, FewPairsTellNothing) {
  const auto low = [](int) { return 0.8; };
  EXPECT_EQ(learnLimit(low, 0), 0.9);
  EXPECT_EQ(learnLimit(low, static_cast<int>(ViewCosine::kLeastPairs) - 1), 0.9);
  EXPECT_LT(learnLimit(low, static_cast<int>(ViewCosine::kLeastPairs)), 0.9);
}

TEST(ViewCosine, LimitIsNeverAboveTheConfiguredOne) {
  EXPECT_EQ(learnLimit([](int) { return 0.99; }, 100), 0.9);
  EXPECT_EQ(learnLimit([](int) { return 0.99; }, 100, 0.6), 0.6);
}

TEST(ViewCosine, LimitLiesBelowNearlyAllViewsOfOneThing) {
  // Even between 0.80 and 0.90: quartile at 0.825, median 0.85.
  const double limit = learnLimit([](int i) { return 0.80 + 0.001 * (i % 100); }, 1000);
  EXPECT_LT(limit, 0.80);
  EXPECT_GT(limit, 0.71);
}

TEST(ViewCosine, DifferentThingsAmongThePairsCountLittle) {
  const auto mixed = [](int i) { return i % 5 == 0 ? 0.3 : 0.86 + 0.002 * (i % 10); };
  const double limit = learnLimit(mixed, 1000);
  EXPECT_GT(limit, 0.78);
  EXPECT_LT(limit, 0.87);
}

TEST(ViewCosine, LimitIsNeverBelowAFloor) {
  EXPECT_EQ(learnLimit([](int i) { return i % 2 == 0 ? 0.1 : 0.6; }, 100),
            ViewCosine::kLeastCosine);
}

/// Views of one thing whose cosines with each other are near 0.8: e + noise of half its length.
Embedding makeNoisyView(int thing, int view) {
  constexpr Eigen::Index kSize = 256;
  std::mt19937 random(static_cast<unsigned>(1000 * thing + view + 1));
  std::normal_distribution<float> normal(0.0F, 0.5F / std::sqrt(static_cast<float>(kSize)));
  Embedding embedding = Embedding::Zero(kSize);
  embedding[thing] = 1.0F;
  for (Eigen::Index i = 0; i < kSize; ++i) embedding[i] += normal(random);
  return embedding.normalized();
}

/// Three things side by side in each of 40 frames.
TrackerCounters trackNoisyViews(const TrackerConfig& config) {
  Tracker tracker(config);
  for (int i = 0; i < 40; ++i) {
    WallCamera wall = wallAt(1.0 + 0.1 * i);
    for (int thing = 0; thing < 3; ++thing) wall.add(6 * thing, 4, makeNoisyView(thing, i));
    wall.giveTo(tracker);
  }
  return tracker.counters();
}

TEST(Tracker, ViewsLessAlikeThanThePresetExpectsAreStillOneTrack) {
  const TrackerCounters adapted = trackNoisyViews({});
  EXPECT_LT(adapted.min_cosine, 0.85);
  EXPECT_LT(adapted.tracks_started, 40U);  // those of the first frames, and three that last
  EXPECT_GT(adapted.associations, 80U);
  TrackerConfig fixed;
  fixed.adapt_cosine = false;
  const TrackerCounters as_in_the_paper = trackNoisyViews(fixed);
  EXPECT_EQ(as_in_the_paper.min_cosine, 0.9);
  EXPECT_GT(as_in_the_paper.tracks_started, 60U);
}

TEST(Tracker, CosineThatIsGivenIsNotAdapted) {
  TrackerConfig config;
  config.min_cosine = 0.95;
  EXPECT_EQ(trackNoisyViews(config).min_cosine, 0.95);
}

TEST(Tracker, DifferentThingsInOnePlaceStayTwoTracksAmongNoisyViews) {
  Tracker tracker{TrackerConfig{}};
  for (int i = 0; i < 40; ++i) {
    WallCamera wall = wallAt(1.0 + 0.1 * i);
    for (int thing = 0; thing < 3; ++thing) wall.add(6 * thing, 4, makeNoisyView(thing, i));
    wall.giveTo(tracker);
  }
  const std::uint64_t before = tracker.counters().tracks_started;
  wallAt(5.0).add(0, 4, makeNoisyView(7, 99)).giveTo(tracker);
  EXPECT_EQ(tracker.counters().tracks_started, before + 1);
}

TEST(Tracker, CosineBelowTheThresholdOpensATrack) {
  for (const double cosine : {0.91, 0.89}) {
    Tracker tracker{TrackerConfig{}};
    const auto first = wallAt(1.0).add(0, 4, kForward).giveTo(tracker);
    const auto second = wallAt(1.1).add(0, 4, embeddingWithCosine(cosine)).giveTo(tracker);
    EXPECT_EQ(second.segment_tracks[0] == first.segment_tracks[0], cosine > 0.9);
  }
}

TEST(Tracker, SegmentGoesToTheTrackWithTheHighestIoU) {
  Tracker tracker{configWith(-0.99, 0.1)};
  const auto first = wallAt(1.0).add(0, 4, kForward).add(4, 4, kForward).giveTo(tracker);
  const auto second = wallAt(1.1).add(3, 4, kForward).giveTo(tracker);
  EXPECT_EQ(second.segment_tracks[0], first.segment_tracks[1]);
}

TEST(Tracker, TrackTakesOnlyItsBestSegmentOfAFrame) {
  Tracker tracker{configWith(-0.99, 0.1)};
  const auto first = wallAt(1.0).add(0, 8, kForward).giveTo(tracker);
  const auto second = wallAt(1.1).add(0, 3, kForward).add(3, 5, kForward).giveTo(tracker);
  EXPECT_EQ(second.segment_tracks[1], first.segment_tracks[0]);
  EXPECT_NE(second.segment_tracks[0], first.segment_tracks[0]);
  EXPECT_TRUE(second.segment_tracks[0].isValid());
}

TEST(Tracker, EqualIoUGoesToTheOlderTrack) {
  Tracker tracker{configWith(-0.99, 0.1)};
  const auto first = wallAt(1.0).add(0, 2, kForward).add(2, 2, kForward).giveTo(tracker);
  const auto second = wallAt(1.1).add(0, 4, kForward).giveTo(tracker);
  EXPECT_EQ(second.segment_tracks[0], first.segment_tracks[0]);
}

TEST(Tracker, TracksOfThisFrameAreNoCandidates) {
  // In voxels of 1 m both segments occupy the same voxel.
  TrackerConfig coarse = configWith(-0.99, 0.0);
  coarse.voxel_size_m = 1.0;
  Tracker coarse_tracker{coarse};
  const auto result = wallAt(1.0).add(0, 2, kForward).add(2, 2, kForward).giveTo(coarse_tracker);
  EXPECT_NE(result.segment_tracks[0], result.segment_tracks[1]);
}

TEST(Tracker, IoUIsTakenWithTheLastObservationOnly) {
  Tracker tracker{configWith(-0.99, 0.5)};
  const auto first = wallAt(1.0).add(0, 6, kForward).giveTo(tracker);
  wallAt(1.1).add(2, 6, kForward).giveTo(tracker);
  const auto third = wallAt(1.2).add(4, 6, kForward).giveTo(tracker);
  EXPECT_EQ(third.segment_tracks[0], first.segment_tracks[0]);
  const auto fourth = wallAt(1.3).add(0, 6, kForward).giveTo(tracker);
  EXPECT_NE(fourth.segment_tracks[0], first.segment_tracks[0]);
}

TEST(Tracker, TouchingNoVoxelIsNoCandidateEvenWithoutAnIoULimit) {
  Tracker tracker{configWith(-0.99, 0.0)};
  const auto first = wallAt(1.0).add(0, 2, kForward).giveTo(tracker);
  const auto second = wallAt(1.1).add(4, 2, kForward).giveTo(tracker);
  EXPECT_NE(second.segment_tracks[0], first.segment_tracks[0]);
}

TEST(Tracker, TrackEndsOnlyAfterMoreThanTheWindow) {
  Tracker tracker{TrackerConfig{}};
  wallAt(1.0).add(0, 4, kForward).giveTo(tracker);
  wallAt(2.0).add(0, 4, kForward).giveTo(tracker);
  EXPECT_TRUE(wallAt(7.0).giveTo(tracker).finished.empty());
  const auto ended = wallAt(7.1).giveTo(tracker);
  ASSERT_EQ(ended.finished.size(), 1U);
  EXPECT_TRUE(ended.live.empty());
  EXPECT_EQ(ended.finished[0].first_seen, Stamp::fromSeconds(1.0));
  EXPECT_EQ(ended.finished[0].last_seen, Stamp::fromSeconds(2.0));
  EXPECT_EQ(ended.finished[0].observations.size(), 2U);
}

TEST(Tracker, TrackPastItsWindowIsNoCandidate) {
  Tracker tracker{TrackerConfig{}};
  const auto first = wallAt(1.0).add(0, 4, kForward).giveTo(tracker);
  const auto late = wallAt(6.5).add(0, 4, kForward).giveTo(tracker);
  EXPECT_NE(late.segment_tracks[0], first.segment_tracks[0]);
}

TEST(Tracker, TracksWithTooFewObservationsAreDroppedAndCounted) {
  Tracker tracker{TrackerConfig{}};
  wallAt(1.0).add(0, 4, kForward).add(10, 4, kForward).giveTo(tracker);
  wallAt(1.1).add(0, 4, kForward).giveTo(tracker);
  const auto ended = tracker.finish();
  ASSERT_EQ(ended.finished.size(), 1U);
  EXPECT_EQ(ended.finished[0].observations.size(), 2U);
  EXPECT_EQ(tracker.counters().tracks_dropped, 1U);
  EXPECT_EQ(tracker.counters().tracks_finished, 1U);
}

TEST(Tracker, FinishEndsEveryTrackAscendingById) {
  TrackerConfig config;
  config.min_observations = 1;
  Tracker tracker{config};
  wallAt(1.0).add(0, 4).add(5, 4).add(10, 4).giveTo(tracker);
  const auto ended = tracker.finish();
  ASSERT_EQ(ended.finished.size(), 3U);
  EXPECT_LT(ended.finished[0].id, ended.finished[1].id);
  EXPECT_LT(ended.finished[1].id, ended.finished[2].id);
  EXPECT_TRUE(ended.live.empty());
  EXPECT_EQ(ended.stamp, Stamp::fromSeconds(1.0));
  EXPECT_EQ(tracker.numLiveTracks(), 0U);
  const auto later = wallAt(2.0).add(0, 4).giveTo(tracker);
  EXPECT_LT(ended.finished[2].id, later.segment_tracks[0]);
}

TEST(Tracker, LiveTracksAreDescribedAsTheyWouldEndAndGoOn) {
  Tracker tracker{TrackerConfig{}};
  Tracker undisturbed{TrackerConfig{}};
  for (int i = 0; i < 6; ++i) {
    const WallCamera wall = wallAt(1.0 + 0.1 * i).add(0, 4, kForward);
    wall.giveTo(tracker);
    wall.giveTo(undisturbed);
    tracker.describeLiveTracks(true);
  }
  const auto described = tracker.describeLiveTracks(true);
  const auto ended = tracker.finish();
  const auto expected = undisturbed.finish();
  ASSERT_EQ(described.size(), 1U);
  ASSERT_EQ(ended.finished.size(), 1U);
  EXPECT_EQ(described[0].id, ended.finished[0].id);
  EXPECT_EQ(described[0].observations.size(), 6U);
  EXPECT_EQ(described[0].last_seen, ended.finished[0].last_seen);
  EXPECT_EQ(described[0].views.best_pixels, ended.finished[0].views.best_pixels);
  EXPECT_EQ(described[0].embedding, ended.finished[0].embedding);
  EXPECT_EQ(ended.finished[0].embedding, expected.finished[0].embedding);
  EXPECT_EQ(ended.finished[0].observations.size(), expected.finished[0].observations.size());
}

TEST(Tracker, LiveTracksAreDescribedEachTimeTheyHaveTripled) {
  Tracker tracker{TrackerConfig{}};
  std::vector<std::size_t> sizes;
  for (int i = 0; i < 40; ++i) {
    wallAt(1.0 + 0.1 * i).add(0, 4, kForward).giveTo(tracker);
    for (const Track& track : tracker.describeLiveTracks(false)) {
      sizes.push_back(track.observations.size());
    }
  }
  EXPECT_EQ(sizes, (std::vector<std::size_t>{4, 12, 36}));
}

TEST(Tracker, TracksThatWouldBeDroppedAreNotDescribed) {
  TrackerConfig config;
  config.min_observations = 6;
  Tracker tracker{config};
  for (int i = 0; i < 5; ++i) wallAt(1.0 + 0.1 * i).add(0, 4, kForward).giveTo(tracker);
  EXPECT_TRUE(tracker.describeLiveTracks(true).empty());
  wallAt(2.0).add(0, 4, kForward).giveTo(tracker);
  EXPECT_EQ(tracker.describeLiveTracks(true).size(), 1U);
}

TEST(Tracker, MeanCountsEveryObservationTheFirstIncluded) {
  Tracker tracker{configWith(-0.99, 0.5)};
  wallAt(1.0).add(0, 4, makeEmbedding({1.0F, 0.0F})).giveTo(tracker);
  wallAt(1.1).add(0, 4, makeEmbedding({0.0F, 1.0F})).giveTo(tracker);
  wallAt(1.2).add(0, 4, makeEmbedding({1.0F, 1.0F})).giveTo(tracker);
  const auto ended = tracker.finish();
  ASSERT_EQ(ended.finished.size(), 1U);
  EXPECT_TRUE(ended.finished[0].embedding.isApprox(makeEmbedding({2.0F / 3, 2.0F / 3}), 1e-6F));
}

TEST(Tracker, MeanWeightedByPixelsFollowsTheLargerView) {
  TrackerConfig config = configWith(-0.99, 0.2);
  config.feature_weight = FeatureWeight::kPixels;
  Tracker tracker{config};
  wallAt(1.0).add(0, 3, makeEmbedding({1.0F, 0.0F})).giveTo(tracker);
  wallAt(1.1).add(0, 1, makeEmbedding({0.0F, 1.0F})).giveTo(tracker);
  const auto ended = tracker.finish();
  ASSERT_EQ(ended.finished.size(), 1U);
  EXPECT_TRUE(ended.finished[0].embedding.isApprox(makeEmbedding({0.75F, 0.25F}), 1e-6F));
}

TEST(Tracker, MeanWeightedByDistanceFollowsTheNearerView) {
  TrackerConfig config = configWith(-0.99, 0.2);
  config.feature_weight = FeatureWeight::kDistance;
  Tracker tracker{config};
  wallAt(1.0).add(0, 4, makeEmbedding({1.0F, 0.0F})).giveTo(tracker);
  auto near = wallAt(1.1).add(0, 8, makeEmbedding({0.0F, 1.0F}));  // half of the same part
  near.frame_.T_world_camera.translation().z() += 1.0;
  near.frame_.depth.image.setTo(1000);
  near.giveTo(tracker);
  const auto ended = tracker.finish();
  ASSERT_EQ(ended.finished.size(), 1U);
  const ViewStatistics& views = ended.finished[0].views;
  const double far_m = 2.0 * views.mean_distance_m - views.min_distance_m;
  const double near_weight = std::pow(views.min_distance_m, -2);
  const double far_weight = std::pow(far_m, -2);
  const auto share = static_cast<float>(near_weight / (near_weight + far_weight));
  EXPECT_GT(share, 0.7F);
  EXPECT_TRUE(ended.finished[0].embedding.isApprox(makeEmbedding({1.0F - share, share}), 1e-5F));
}

TEST(Tracker, MeanWeightedByViewAngleFollowsTheFrontalView) {
  // A floor seen at a low angle, then the same voxels from right above.
  TrackerConfig config = configWith(-0.99, 0.05);
  config.max_image_share = 1.0;
  config.feature_weight = FeatureWeight::kViewAngle;
  Tracker tracker{config};
  auto above = wallAt(1.0).add(0, 20, makeEmbedding({1.0F, 0.0F}));
  above.giveTo(tracker);
  auto slanted = wallAt(1.1).add(0, 20, makeEmbedding({0.0F, 1.0F}));
  const Eigen::Vector3d wall_point(1.0, 0.5, 2.05);
  const double angle_rad = 1.2;  // of the line of sight to the wall's normal
  slanted.frame_.T_world_camera.linear() =
      Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  slanted.frame_.camera.cx_px = 49.5;
  slanted.frame_.camera.cy_px = 24.5;
  const Eigen::Vector3d axis = slanted.frame_.T_world_camera.linear().col(2);
  slanted.frame_.T_world_camera.translation() = wall_point - 2.0 * axis;
  for (int v = 0; v < 50; ++v) {
    for (int u = 0; u < 100; ++u) {
      const Eigen::Vector3d ray =
          slanted.frame_.T_world_camera.linear() * slanted.frame_.camera.unproject(u, v, 1.0);
      const double z_m = (2.05 - slanted.frame_.T_world_camera.translation().z()) / ray.z();
      const bool hits = ray.z() > 0.0 && z_m < 5.0;
      slanted.frame_.depth.image.at<std::uint16_t>(v, u) =
          hits ? static_cast<std::uint16_t>(1000.0 * z_m) : std::uint16_t{0};
    }
  }
  slanted.giveTo(tracker);
  const auto ended = tracker.finish();
  ASSERT_EQ(ended.finished.size(), 1U);
  const Embedding& mean = ended.finished[0].embedding;
  EXPECT_GT(mean[0], 0.6F);
  EXPECT_GT(mean[1], 0.1F);
  EXPECT_NEAR(mean.sum(), 1.0F, 1e-5F);
  EXPECT_NEAR(ended.finished[0].views.spread_rad, angle_rad, 0.5);
}

TEST(Tracker, FinishedTracksKnowTheirBestView) {
  Tracker tracker{configWith(-0.99, 0.1)};
  wallAt(1.0).add(1, 2).giveTo(tracker);
  wallAt(1.1).add(15, 2).add(1, 4).giveTo(tracker);
  wallAt(1.2).add(1, 3).giveTo(tracker);
  const auto ended = tracker.finish();
  ASSERT_EQ(ended.finished.size(), 1U);
  const ViewStatistics& views = ended.finished[0].views;
  EXPECT_EQ(views.best.stamp, Stamp::fromSeconds(1.1));
  EXPECT_EQ(views.best.segment, 2);
  EXPECT_EQ(views.best_pixels, 1000U);
  EXPECT_GT(views.min_distance_m, 2.0);
  EXPECT_LT(views.mean_distance_m, 2.3);
}

TEST(Tracker, SegmentWithoutEmbeddingMatchesByIoUAndStaysOutOfTheMean) {
  Tracker tracker{TrackerConfig{}};
  const Embedding none = Embedding::Zero(2);
  const auto first = wallAt(1.0).add(0, 4, none).giveTo(tracker);
  wallAt(1.1).add(0, 4, kForward).giveTo(tracker);
  wallAt(1.2).add(0, 4, none).giveTo(tracker);
  const auto ended = tracker.finish();
  ASSERT_EQ(ended.finished.size(), 1U);
  EXPECT_EQ(ended.finished[0].id, first.segment_tracks[0]);
  EXPECT_EQ(ended.finished[0].observations.size(), 3U);
  EXPECT_EQ(ended.finished[0].embedding, kForward);
}

TEST(Tracker, TrackNeverEmbeddedHasAnEmptyEmbedding) {
  Tracker tracker{TrackerConfig{}};
  wallAt(1.0).add(0, 4).giveTo(tracker);
  wallAt(1.1).add(0, 4).giveTo(tracker);
  const auto ended = tracker.finish();
  ASSERT_EQ(ended.finished.size(), 1U);
  EXPECT_EQ(ended.finished[0].embedding.size(), 0);
}

TEST(Tracker, SegmentsTooSmallOrTooLargeAreIgnoredAndCounted) {
  TrackerConfig config;
  config.min_pixels = 251;
  config.max_image_share = 0.3;
  Tracker tracker{config};
  // 250, 300 and 1750 pixels of 5000.
  auto wall = wallAt(1.0).add(0, 1).add(1, 7).add(10, 1);
  wall.segmentation_.labels(cv::Rect(55, 0, 1, 50)).setTo(3);
  const auto result = wall.giveTo(tracker);
  EXPECT_FALSE(result.segment_tracks[0].isValid());
  EXPECT_FALSE(result.segment_tracks[1].isValid());
  EXPECT_TRUE(result.segment_tracks[2].isValid());
  EXPECT_EQ(tracker.counters().small_segments, 1U);
  EXPECT_EQ(tracker.counters().large_segments, 1U);
  EXPECT_EQ(tracker.counters().segments, 3U);
}

TEST(Tracker, PixelsOutOfRangeOrWithoutDepthAreNoPoints) {
  TrackerConfig config;
  config.max_range_m = 2.5;
  Tracker tracker{config};
  auto wall = wallAt(1.0).add(0, 4).add(5, 4).add(10, 4);
  wall.frame_.depth.image(cv::Rect(0, 0, 20, 50)).setTo(3000);
  wall.frame_.depth.image(cv::Rect(25, 0, 20, 50)).setTo(65535);
  const auto result = wall.giveTo(tracker);
  EXPECT_FALSE(result.segment_tracks[0].isValid());
  EXPECT_FALSE(result.segment_tracks[1].isValid());
  EXPECT_TRUE(result.segment_tracks[2].isValid());
  EXPECT_EQ(tracker.counters().small_segments, 2U);
}

TEST(Tracker, AFrameTwiceOrFromThePastIsIgnoredAndCounted) {
  Tracker tracker{TrackerConfig{}};
  const auto first = wallAt(2.0).add(0, 4, kForward).giveTo(tracker);
  for (const double stamp_s : {2.0, 1.0, -100.0}) {
    const auto result = wallAt(stamp_s).add(0, 4, kForward).giveTo(tracker);
    EXPECT_EQ(result.segment_tracks, std::vector<TrackId>{TrackId{}});
    EXPECT_EQ(result.live, first.live);
    EXPECT_TRUE(result.finished.empty());
  }
  EXPECT_EQ(tracker.counters().out_of_order_frames, 3U);
  EXPECT_EQ(tracker.counters().associations, 0U);
}

class InvalidFrame : public testing::TestWithParam<std::function<void(WallCamera&)>> {};

TEST_P(InvalidFrame, IsIgnoredAndCounted) {
  Tracker tracker{TrackerConfig{}};
  const auto first = wallAt(1.0).add(0, 4, kForward).giveTo(tracker);
  auto wall = wallAt(1.1).add(0, 4, kForward);
  GetParam()(wall);
  const auto result = wall.giveTo(tracker);
  EXPECT_EQ(tracker.counters().invalid_frames, 1U);
  EXPECT_FALSE(result.segment_tracks.at(0).isValid());
  EXPECT_EQ(result.live, first.live);
  // The stamp of a frame that was ignored does not count.
  const auto good = wallAt(1.1).add(0, 4, kForward).giveTo(tracker);
  EXPECT_EQ(good.segment_tracks, first.segment_tracks);
}

INSTANTIATE_TEST_SUITE_P(
    Faults, InvalidFrame,
    testing::Values([](WallCamera& w) { w.segmentation_.stamp.ns += 1; },
                    [](WallCamera& w) { w.segmentation_.labels.at<std::uint16_t>(3, 3) = 2; },
                    [](WallCamera& w) { w.segmentation_.labels = cv::Mat(); },
                    [](WallCamera& w) {
                      w.segmentation_.labels.convertTo(w.segmentation_.labels, CV_8U);
                    },
                    [](WallCamera& w) { w.frame_.depth.image = cv::Mat(10, 10, CV_16UC1); },
                    [](WallCamera& w) { w.frame_.depth.image = cv::Mat(50, 100, CV_64FC1); },
                    [](WallCamera& w) { w.segmentation_.embeddings.setConstant(NAN); },
                    [](WallCamera& w) { w.segmentation_.embeddings.setOnes(1, 3); },
                    [](WallCamera& w) { w.frame_.T_world_camera.translation().x() = NAN; },
                    [](WallCamera& w) { w.frame_.T_world_camera.translation().y() = 1e9; }));

TEST(Tracker, JumpOfThePoseByMetresOpensNewTracks) {
  Tracker tracker{TrackerConfig{}};
  const auto first = wallAt(1.0).add(0, 4, kForward).giveTo(tracker);
  auto wall = wallAt(1.1).add(0, 4, kForward);
  wall.frame_.T_world_camera.translation().x() += 3.0;
  EXPECT_NE(wall.giveTo(tracker).segment_tracks[0], first.segment_tracks[0]);
}

TEST(Tracker, DepthOfZeroOrNanEverywhereOpensNoTrack) {
  Tracker tracker{TrackerConfig{}};
  auto zero = wallAt(1.0).add(0, 4, kForward);
  zero.frame_.depth.image.setTo(0);
  EXPECT_FALSE(zero.giveTo(tracker).segment_tracks[0].isValid());
  auto nan = wallAt(1.1).add(0, 4, kForward);
  nan.frame_.depth.image =
      cv::Mat(50, 100, CV_32FC1, cv::Scalar(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(nan.giveTo(tracker).segment_tracks[0].isValid());
  EXPECT_EQ(tracker.counters().small_segments, 2U);
}

TEST(Tracker, FrameWithoutSegmentsIsFine) {
  Tracker tracker{TrackerConfig{}};
  const auto result = wallAt(1.0).giveTo(tracker);
  EXPECT_TRUE(result.segment_tracks.empty());
  EXPECT_EQ(tracker.counters().invalid_frames, 0U);
}

}  // namespace
}  // namespace tsg::tracking
