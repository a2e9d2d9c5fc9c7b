// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/embedding_schedule.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace tsg::segmentation {
namespace {

constexpr int kCropsPerSegment = 2;
constexpr double kPeriod_s = 0.1;

struct Patch {
  cv::Rect box;
  cv::Scalar color;
};

ScheduleConfig reuse() {
  ScheduleConfig config;
  config.mode = ScheduleMode::kReuse;
  return config;
}

/// A schedule, an encoder that counts, and a world of coloured rectangles.
class World {
 public:
  explicit World(const ScheduleConfig& config) : schedule_(config, kCropsPerSegment) {}

  /// The next image. The encoder gives segment i (1 for red, 2 for green, 3 for blue, time).
  /// `shift_px`: where the image before lies in this one, for the schedule to know.
  EmbeddingMatrix show(const std::vector<Patch>& patches, double dt_s = kPeriod_s,
                       std::optional<cv::Point> shift_px = {}) {
    time_s_ += dt_s;
    const cv::Mat image = draw(patches);
    plan_ = schedule_.plan({Stamp::fromSeconds(time_s_), image, ColorOrder::kRgb, nullptr},
                           segments_, shift_px ? makeShift(*shift_px) : ImageMotion());
    embedded = plan_.embed;
    EmbeddingMatrix fresh(static_cast<Eigen::Index>(embedded.size()), 4);
    for (std::size_t row = 0; row < embedded.size(); ++row) {
      fresh.row(static_cast<Eigen::Index>(row)) = encode(patches[embedded[row]]);
    }
    return schedule_.commit(plan_, fresh);
  }

  Eigen::RowVector4f encode(const Patch& patch) const {
    if (broken) return Eigen::RowVector4f::Zero();
    const Eigen::RowVector4f color(static_cast<float>(patch.color[0]),
                                   static_cast<float>(patch.color[1]),
                                   static_cast<float>(patch.color[2]), 40.0F);
    return color.normalized();
  }
  const EmbeddingSchedule::Plan& plan() const { return plan_; }
  EmbeddingSchedule& schedule() { return schedule_; }

  std::vector<std::size_t> embedded;  ///< in the newest image
  bool broken = false;

 private:
  static ImageMotion makeShift(cv::Point shift_px) {
    ImageMotion motion;
    motion.image_size_px = {640, 480};
    motion.origins_px.create(motion.image_size_px, CV_32FC2);
    motion.is_known = cv::Mat(motion.image_size_px, CV_8UC1, cv::Scalar(255));
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u < 640; ++u) {
        motion.origins_px.at<cv::Vec2f>(v, u) = {static_cast<float>(u - shift_px.x),
                                                 static_cast<float>(v - shift_px.y)};
      }
    }
    return motion;
  }

  cv::Mat draw(const std::vector<Patch>& patches) {
    cv::Mat image(480, 640, CV_8UC3, cv::Scalar(90, 90, 90));
    segments_ = {};
    segments_.labels = cv::Mat::zeros(image.size(), CV_16UC1);
    for (std::size_t i = 0; i < patches.size(); ++i) {
      image(patches[i].box) = patches[i].color;
      segments_.labels(patches[i].box) = cv::Scalar(static_cast<double>(i + 1));
      segments_.boxes_px.push_back(patches[i].box);
      segments_.areas_px.push_back(patches[i].box.area());
      segments_.scores.push_back(0.5F);
    }
    return image;
  }

  EmbeddingSchedule schedule_;
  EmbeddingSchedule::Plan plan_;
  LabelledSegments segments_;
  double time_s_ = 100.0;
};

const Patch kRed{{100, 100, 60, 80}, {200, 20, 20}};
const Patch kGreen{{300, 200, 90, 50}, {20, 200, 20}};
const Patch kBlue{{450, 300, 40, 40}, {20, 20, 200}};

using Indices = std::vector<std::size_t>;

TEST(EmbeddingSchedule, AStaticSceneIsEmbeddedOnce) {
  World world(reuse());
  const EmbeddingMatrix first = world.show({kRed, kGreen, kBlue});
  EXPECT_EQ(std::set<std::size_t>(world.embedded.begin(), world.embedded.end()).size(), 3U);
  for (int i = 0; i < 15; ++i) {
    EXPECT_TRUE(world.show({kRed, kGreen, kBlue}).isApprox(first));
    EXPECT_EQ(world.embedded, Indices{});
    EXPECT_EQ(world.plan().reuse, (Indices{0, 1, 2}));
  }
}

TEST(EmbeddingSchedule, AMovingSegmentKeepsItsEmbeddingUnderAnotherLabel) {
  ScheduleConfig config = reuse();
  config.min_view_gain = 10.0;
  World world(config);
  const EmbeddingMatrix first = world.show({kRed, kGreen});
  Patch red = kRed;
  Patch green = kGreen;
  for (int i = 0; i < 10; ++i) {
    red.box.x += 33;
    green.box.x -= 17;
    const EmbeddingMatrix rows = world.show({green, red});
    EXPECT_EQ(world.embedded, Indices{});
    EXPECT_TRUE(rows.row(1).isApprox(first.row(0)));
    EXPECT_TRUE(rows.row(0).isApprox(first.row(1)));
  }
}

TEST(EmbeddingSchedule, ASegmentThatJumpsIsNew) {
  World world(reuse());
  world.show({kRed});
  Patch far = kRed;
  far.box.x += 200;
  world.show({far});
  EXPECT_EQ(world.embedded, Indices{0});
}

TEST(EmbeddingSchedule, ChangedColoursReplaceTheEmbedding) {
  World world(reuse());
  world.show({kRed, kGreen});
  const Patch repainted{kRed.box, {20, 20, 200}};
  const EmbeddingMatrix rows = world.show({repainted, kGreen});
  EXPECT_EQ(world.embedded, Indices{0});
  EXPECT_TRUE(rows.row(0).isApprox(world.encode(repainted)));
}

/// Every step is small; the comparison is with what was embedded, not with the image before.
TEST(EmbeddingSchedule, SlowChangesOfColourAndSizeAddUp) {
  World world(reuse());
  Patch fading = kRed;
  Patch nearing = kGreen;
  world.show({fading, nearing});
  std::map<std::size_t, int> times;
  for (int i = 0; i < 15; ++i) {
    fading.color -= cv::Scalar(6, 0, -6);
    nearing.box = cv::Rect(nearing.box.x - 3, nearing.box.y - 3, nearing.box.width + 6,
                           nearing.box.height + 6);
    world.show({fading, nearing});
    for (const std::size_t i_segment : world.embedded) ++times[i_segment];
  }
  EXPECT_EQ(times[0], 3);  // 4 steps per mean channel: after 12 / 4 and a bit, of 15
  EXPECT_GE(times[1], 2);
  EXPECT_LE(times[1], 4);
}

TEST(EmbeddingSchedule, OldEmbeddingsAreRefreshedIntoTheirMean) {
  ScheduleConfig config = reuse();
  config.max_age_s = 0.45;
  config.max_color_change_8bit = 50.0;
  World world(config);
  world.show({kRed});
  Patch darker = kRed;
  darker.color = cv::Scalar(150, 20, 20);
  EmbeddingMatrix rows;
  for (int i = 1; i <= 5; ++i) {
    rows = world.show({darker});
    EXPECT_EQ(world.embedded.size(), i == 5 ? 1U : 0U) << i;
  }
  const Eigen::RowVector4f mean = (world.encode(kRed) + world.encode(darker)).normalized();
  EXPECT_TRUE(rows.row(0).isApprox(mean));
}

TEST(EmbeddingSchedule, TheBudgetGoesToNewThenChangedThenOldSegments) {
  ScheduleConfig config = reuse();
  config.max_crops_per_frame = 2 * kCropsPerSegment;
  config.max_age_s = 0.05;  // all are old at once
  World world(config);
  const EmbeddingMatrix first = world.show({kRed, kGreen});
  const Patch repainted{kGreen.box, {20, 20, 200}};
  const Patch fresh{{500, 60, 20, 20}, {200, 200, 20}};
  const EmbeddingMatrix rows = world.show({kRed, repainted, fresh});
  EXPECT_EQ(world.embedded, (Indices{2, 1}));
  EXPECT_EQ(world.plan().reuse, Indices{0});
  EXPECT_TRUE(rows.row(0).isApprox(first.row(0)));
}

TEST(EmbeddingSchedule, ChangedSegmentsOverTheBudgetKeepWhatTheyHave) {
  ScheduleConfig config = reuse();
  config.max_crops_per_frame = kCropsPerSegment;
  World world(config);
  const EmbeddingMatrix first = world.show({kRed});
  const Patch repainted{kRed.box, {20, 20, 200}};
  EXPECT_TRUE(world.show({repainted, kGreen}).row(0).isApprox(first.row(0)));
  EXPECT_EQ(world.embedded, Indices{1});
  EXPECT_TRUE(world.show({repainted, kGreen}).row(0).isApprox(world.encode(repainted)));
  EXPECT_EQ(world.embedded, Indices{0});
}

TEST(EmbeddingSchedule, NewSegmentsOverTheBudgetAreDroppedUntilItIsTheirTurn) {
  ScheduleConfig config = reuse();
  config.max_crops_per_frame = kCropsPerSegment;
  World world(config);
  const std::vector<Patch> patches = {kBlue, kRed, kGreen};
  std::set<std::size_t> seen;
  for (std::size_t turn = 1; turn <= 3; ++turn) {
    const EmbeddingMatrix rows = world.show(patches);
    ASSERT_EQ(world.embedded.size(), 1U);
    seen.insert(world.embedded[0]);
    EXPECT_EQ(world.plan().dropped.size(), 3 - turn);
    for (const std::size_t i : world.plan().dropped) {
      EXPECT_TRUE(rows.row(static_cast<Eigen::Index>(i)).isZero(0.0F));
    }
  }
  EXPECT_EQ(seen.size(), 3U);
}

TEST(EmbeddingSchedule, OneSegmentIsEmbeddedEvenIfTheBudgetIsLessThanItsCrops) {
  ScheduleConfig config = reuse();
  config.max_crops_per_frame = 1;
  World world(config);
  world.show({kRed, kGreen});
  EXPECT_EQ(world.embedded.size(), 1U);
}

TEST(EmbeddingSchedule, ATimeBudgetIsDividedByWhatACropTook) {
  ScheduleConfig config = reuse();
  config.max_ms_per_frame = 45.0;
  World world(config);
  world.show({kRed, kGreen, kBlue});
  EXPECT_EQ(world.embedded.size(), 3U);  // nothing is known yet
  world.schedule().addCost(6, 60.0);
  const Patch moved[] = {{{20, 20, 20, 20}, {200, 200, 20}},
                         {{120, 400, 30, 20}, {20, 200, 200}},
                         {{500, 60, 20, 30}, {200, 20, 200}}};
  world.show({moved[0], moved[1], moved[2]});
  EXPECT_EQ(world.embedded.size(), 2U);  // 4 crops of 10 ms
  EXPECT_EQ(world.plan().dropped.size(), 1U);
}

TEST(EmbeddingSchedule, ABetterViewIsEmbeddedAndWeighsMore) {
  ScheduleConfig config = reuse();
  config.max_color_change_8bit = 50.0;
  World world(config);
  const Patch far{{300, 220, 40, 40}, {200, 20, 20}};
  const Patch near{{292, 212, 56, 56}, {150, 20, 20}};
  world.show({far});
  const EmbeddingMatrix rows = world.show({near});
  EXPECT_EQ(world.embedded, Indices{0});
  const double weight_near = world.plan().memories[0].quality_px;
  const Eigen::RowVector4f mean =
      world.encode(far) + 1.4F * world.encode(near);  // both are central, sides as 40 to 56
  EXPECT_GT(weight_near, 50.0);
  EXPECT_TRUE(rows.row(0).isApprox(mean.normalized(), 1e-3F));
  world.show({far});
  EXPECT_EQ(world.embedded, Indices{});
}

TEST(EmbeddingSchedule, AThingThatComesIntoViewContinuesByItsOverlap) {
  ScheduleConfig config = reuse();
  config.min_view_gain = 100.0;
  const Patch part{{0, 200, 30, 100}, {200, 20, 20}};
  const Patch whole{{0, 200, 90, 100}, {200, 20, 20}};
  for (const bool knows_motion : {false, true}) {
    World world(config);
    world.show({part});
    world.show({whole}, kPeriod_s, knows_motion ? std::optional<cv::Point>({60, 0}) : std::nullopt);
    EXPECT_EQ(world.embedded.empty(), knows_motion);
  }
}

TEST(EmbeddingSchedule, WhatOverlapsButLooksDifferentIsNew) {
  World world(reuse());
  world.show({{{0, 200, 30, 100}, {200, 20, 20}}});
  world.show({{{0, 200, 90, 100}, {20, 20, 200}}}, kPeriod_s, cv::Point(60, 0));
  EXPECT_EQ(world.embedded, Indices{0});
}

TEST(EmbeddingSchedule, LargeCentralAndWholeViewsComeFirst) {
  const cv::Scalar color(200, 20, 20);
  const Patch cut{{0, 200, 60, 60}, color};
  const Patch corner{{10, 10, 60, 60}, color};
  const Patch central{{290, 210, 60, 60}, color};
  const Patch large{{380, 210, 120, 120}, color};
  World world(reuse());
  world.show({cut, corner, central, large});
  EXPECT_EQ(world.embedded, (Indices{3, 2, 1, 0}));
}

TEST(EmbeddingSchedule, NothingIsReusedAfterAGapAStepBackOrARepeatedStamp) {
  for (const double dt_s : {1.5, -0.5, 0.0}) {
    World world(reuse());
    world.show({kRed});
    world.show({kRed}, dt_s);
    EXPECT_EQ(world.embedded, Indices{0}) << dt_s;
    EXPECT_TRUE(world.plan().embed_image) << dt_s;
  }
}

TEST(EmbeddingSchedule, TheWholeImageIsEmbeddedOncePerPeriod) {
  ScheduleConfig config = reuse();
  config.image_period_s = 0.25;
  World world(config);
  std::vector<bool> embedded;
  for (int i = 0; i < 7; ++i) {
    world.show({});
    embedded.push_back(world.plan().embed_image);
  }
  EXPECT_EQ(embedded, (std::vector<bool>{true, false, false, true, false, false, true}));
}

TEST(EmbeddingSchedule, WhatTheEncoderFailedOnIsTriedAgain) {
  World world(reuse());
  world.broken = true;
  EXPECT_TRUE(world.show({kRed}).isZero(0.0F));
  world.broken = false;
  EXPECT_TRUE(world.show({kRed}).row(0).isApprox(world.encode(kRed)));
  EXPECT_EQ(world.embedded, Indices{0});
}

TEST(EmbeddingSchedule, OfTwoEqualSegmentsEachContinuesTheNearerOne) {
  World world(reuse());
  const Patch left{{200, 200, 40, 40}, {200, 20, 20}};
  const Patch right{{250, 200, 40, 40}, {190, 20, 20}};
  const EmbeddingMatrix first = world.show({left, right});
  const EmbeddingMatrix rows = world.show({left, right});
  EXPECT_EQ(world.embedded, Indices{});
  EXPECT_TRUE(rows.isApprox(first));
}

TEST(EmbeddingSchedule, EverySegmentIsEmbeddedReusedOrDroppedAndTheBudgetHolds) {
  ScheduleConfig config = reuse();
  config.max_crops_per_frame = 3 * kCropsPerSegment + 1;
  World world(config);
  cv::RNG random(11);
  std::vector<Patch> patches;
  for (int frame = 0; frame < 100; ++frame) {
    if (random.uniform(0, 3) == 0 || patches.empty()) {
      patches.clear();
      for (int i = random.uniform(0, 12); i >= 0; --i) {
        patches.push_back({{40 * i + 20, random.uniform(10, 400), 30, random.uniform(10, 60)},
                           cv::Scalar::all(random.uniform(0, 255))});
      }
    }
    const EmbeddingMatrix rows = world.show(patches);
    const auto& plan = world.plan();
    std::multiset<std::size_t> all(plan.embed.begin(), plan.embed.end());
    all.insert(plan.reuse.begin(), plan.reuse.end());
    all.insert(plan.dropped.begin(), plan.dropped.end());
    ASSERT_EQ(all.size(), patches.size());
    EXPECT_EQ(std::set<std::size_t>(all.begin(), all.end()).size(), patches.size());
    EXPECT_LE(plan.embed.size(), 3U);
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      const bool is_dropped = std::count(plan.dropped.begin(), plan.dropped.end(), i) > 0;
      EXPECT_NEAR(rows.row(i).norm(), is_dropped ? 0.0 : 1.0, 1e-5);
    }
  }
}

}  // namespace
}  // namespace tsg::segmentation
