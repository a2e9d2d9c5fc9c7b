// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/pair_matcher.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <random>
#include <set>

namespace tsg::ros_interface {
namespace {

SourceImage makeImage(double seconds) {
  auto image = boost::make_shared<sensor_msgs::Image>();
  image->header.stamp.fromSec(seconds);
  return SourceImage(sensor_msgs::ImageConstPtr(image));
}

double secondsOf(const SourceImage& image) { return image.stamp().seconds(); }

/// Sums up the outcomes of single steps.
struct Collector {
  void operator()(const PairMatcher::Outcome& outcome) {
    for (const auto& pair : outcome.pairs) {
      pairs.emplace_back(secondsOf(pair.color), secondsOf(pair.depth));
    }
    for (const auto& unmatched : outcome.unmatched_colors) {
      colors.push_back(secondsOf(unmatched.color));
      nearest.push_back(unmatched.nearest_s.value_or(-1.0));
    }
    depths += outcome.unmatched_depths;
  }
  std::vector<std::pair<double, double>> pairs;
  std::vector<double> colors;
  std::vector<double> nearest;
  std::size_t depths = 0;
};

TEST(PairMatcher, EqualStampsMatchAtOnceInEitherOrder) {
  PairMatcher matcher(0.02, 10);
  Collector collect;
  collect(matcher.addColor(makeImage(1.0)));
  EXPECT_TRUE(collect.pairs.empty());
  collect(matcher.addDepth(makeImage(1.0)));
  ASSERT_EQ(collect.pairs.size(), 1U);
  collect(matcher.addDepth(makeImage(2.0)));
  collect(matcher.addColor(makeImage(2.0)));
  ASSERT_EQ(collect.pairs.size(), 2U);
}

TEST(PairMatcher, ColourTakesTheNearestDepthImage) {
  PairMatcher matcher(0.1, 10);
  Collector collect;
  collect(matcher.addDepth(makeImage(1.00)));
  collect(matcher.addDepth(makeImage(1.06)));
  collect(matcher.addDepth(makeImage(1.12)));
  collect(matcher.addColor(makeImage(1.05)));
  collect(matcher.addColor(makeImage(2.0)));
  ASSERT_EQ(collect.pairs.size(), 1U);
  EXPECT_NEAR(collect.pairs[0].second, 1.06, 1e-6);
  EXPECT_EQ(collect.depths, 1U);
}

TEST(PairMatcher, DepthGoesToTheColourImageThatIsNearer) {
  PairMatcher matcher(0.05, 10);
  Collector collect;
  collect(matcher.addColor(makeImage(1.00)));
  collect(matcher.addDepth(makeImage(1.03)));
  EXPECT_TRUE(collect.pairs.empty()) << "the next colour image may be nearer";
  collect(matcher.addColor(makeImage(1.04)));
  collect(matcher.addDepth(makeImage(1.50)));
  ASSERT_EQ(collect.pairs.size(), 1U);
  EXPECT_NEAR(collect.pairs[0].first, 1.04, 1e-6);
  ASSERT_EQ(collect.colors.size(), 1U);
  EXPECT_NEAR(collect.nearest[0], 0.03, 1e-6);
}

TEST(PairMatcher, WhatFindsNoPartnerIsReportedWithTheNearestDistance) {
  PairMatcher matcher(0.02, 10);
  Collector collect;
  for (int i = 0; i < 5; ++i) {
    collect(matcher.addColor(makeImage(1.0 + 0.1 * i)));
    collect(matcher.addDepth(makeImage(1.033 + 0.1 * i)));
  }
  collect(matcher.flush());
  EXPECT_TRUE(collect.pairs.empty());
  ASSERT_EQ(collect.colors.size(), 5U);
  for (const double nearest : collect.nearest) EXPECT_NEAR(nearest, 0.033, 1e-6);
  EXPECT_EQ(collect.depths, 5U);
}

TEST(PairMatcher, WithoutAnyDepthNoDistanceIsKnown) {
  PairMatcher matcher(0.02, 2);
  Collector collect;
  for (int i = 0; i < 5; ++i) collect(matcher.addColor(makeImage(1.0 + i)));
  ASSERT_EQ(collect.colors.size(), 3U) << "beyond the capacity the oldest are given up";
  EXPECT_EQ(collect.nearest[0], -1.0);
  EXPECT_EQ(matcher.numWaiting(), 2U);
}

TEST(PairMatcher, ToleranceZeroTakesEqualStampsOnly) {
  PairMatcher matcher(0.0, 10);
  Collector collect;
  collect(matcher.addColor(makeImage(1.0)));
  collect(matcher.addDepth(makeImage(1.000001)));
  collect(matcher.addColor(makeImage(2.0)));
  collect(matcher.addDepth(makeImage(2.0)));
  collect(matcher.flush());
  ASSERT_EQ(collect.pairs.size(), 1U);
  EXPECT_EQ(collect.colors.size(), 1U);
}

TEST(PairMatcher, EveryImageIsUsedOnceOrReported) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> step(0.01, 0.1);
    PairMatcher matcher(0.03, 7);
    Collector collect;
    double color_s = 1.0;
    double depth_s = 1.0;
    const int num_colors = 60;
    int num_depths = 0;
    for (int i = 0; i < num_colors; ++i) {
      color_s += step(random);
      collect(matcher.addColor(makeImage(color_s)));
      while (depth_s < color_s + step(random) - 0.05) {
        depth_s += step(random);
        collect(matcher.addDepth(makeImage(depth_s)));
        ++num_depths;
      }
    }
    collect(matcher.flush());
    EXPECT_EQ(collect.pairs.size() + collect.colors.size(), std::size_t{num_colors});
    EXPECT_EQ(collect.pairs.size() + collect.depths, static_cast<std::size_t>(num_depths));
    std::set<double> colors;
    std::set<double> depths;
    for (const auto& [color, depth] : collect.pairs) {
      EXPECT_LE(std::abs(color - depth), 0.03 + 1e-9);
      EXPECT_TRUE(colors.insert(color).second);
      EXPECT_TRUE(depths.insert(depth).second);
    }
    EXPECT_TRUE(std::is_sorted(collect.pairs.begin(), collect.pairs.end()));
  }
}

TEST(PairMatcher, StreamsAtConstantRatesMatchAllButTheLast) {
  PairMatcher matcher(0.02, 60);
  Collector collect;
  for (int i = 0; i < 100; ++i) {
    collect(matcher.addColor(makeImage(10.0 + i / 30.0)));
    collect(matcher.addDepth(makeImage(10.0 + i / 30.0 + 0.011)));
  }
  EXPECT_EQ(collect.pairs.size(), 99U);
  collect(matcher.flush());
  EXPECT_EQ(collect.pairs.size(), 100U);
  EXPECT_TRUE(collect.colors.empty());
}

}  // namespace
}  // namespace tsg::ros_interface
