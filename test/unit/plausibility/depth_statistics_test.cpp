// SPDX-License-Identifier: BSD-3-Clause
#include "plausibility/depth_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "plausibility/depth_findings.h"

namespace tsg::plausibility {
namespace {

DepthImage makeDepth(const cv::Mat& image, double metres_per_unit) {
  DepthImage depth;
  depth.image = image;
  depth.metres_per_unit = metres_per_unit;
  return depth;
}

/// 40 x 30, so that every pixel is sampled.
cv::Mat makeRandomDepth(std::mt19937& random, std::vector<float>& values) {
  std::lognormal_distribution<float> distribution(0.7F, 0.8F);
  cv::Mat image(30, 40, CV_32FC1);
  for (auto pixel = image.begin<float>(); pixel != image.end<float>(); ++pixel) {
    *pixel = distribution(random);
    values.push_back(*pixel);
  }
  return image;
}

TEST(DepthStatistics, QuantilesAreThoseOfTheSortedReadingsToFourPercent) {
  std::mt19937 random(1);
  std::vector<float> values;
  DepthStatistics statistics;
  for (int i = 0; i < 20; ++i) statistics.add(makeDepth(makeRandomDepth(random, values), 1.0));
  std::sort(values.begin(), values.end());
  for (const double share : {0.05, 0.25, 0.5, 0.75, 0.95}) {
    const auto rank = static_cast<std::size_t>(share * static_cast<double>(values.size()));
    const auto expected = static_cast<double>(values[rank]);
    EXPECT_NEAR(statistics.quantile(share), expected, 0.04 * expected) << share;
  }
}

TEST(DepthStatistics, SharesCountValidReadingsOnly) {
  cv::Mat image(30, 40, CV_32FC1, cv::Scalar(2.0));
  image.rowRange(0, 10).setTo(std::numeric_limits<float>::quiet_NaN());
  image.rowRange(10, 20).setTo(8.0F);
  DepthStatistics statistics;
  statistics.add(makeDepth(image, 1.0));
  EXPECT_EQ(statistics.numReadings(), 1200U);
  EXPECT_NEAR(statistics.validShare(), 2.0 / 3.0, 1e-9);
  EXPECT_NEAR(statistics.shareWithin(0.3, 5.0), 0.5, 1e-9);
}

TEST(DepthStatistics, ReadsMillimetresAndLeavesTheLargestValueOut) {
  cv::Mat image(30, 40, CV_16UC1, cv::Scalar(1500));
  image.colRange(0, 20).setTo(65535);
  DepthStatistics statistics;
  statistics.add(makeDepth(image, 0.001));
  EXPECT_NEAR(statistics.median_m(), 1.5, 0.05);
  EXPECT_DOUBLE_EQ(statistics.validShare(), 0.5);
  EXPECT_NEAR(static_cast<double>(statistics.constantValue_m().value_or(0.0F)), 1.5, 1e-6);
}

TEST(DepthStatistics, TwoValuesAreNotConstant) {
  DepthStatistics statistics;
  statistics.add(makeDepth(cv::Mat(30, 40, CV_16UC1, cv::Scalar(1500)), 0.001));
  statistics.add(makeDepth(cv::Mat(30, 40, CV_16UC1, cv::Scalar(1501)), 0.001));
  EXPECT_FALSE(statistics.constantValue_m().has_value());
}

TEST(DepthStatistics, HoldsKilometresAndTenthsOfMillimetres) {
  for (const double factor : {1e-4, 1e4}) {
    DepthStatistics statistics;
    statistics.add(makeDepth(cv::Mat(30, 40, CV_32FC1, cv::Scalar(2.0)), factor));
    EXPECT_NEAR(statistics.median_m(), 2.0 * factor, 0.08 * factor);
  }
}

TEST(DepthStatistics, OfNothingIsSilent) {
  const DepthStatistics statistics;
  EXPECT_EQ(statistics.median_m(), 0.0);
  EXPECT_FALSE(checkDepthRange(statistics, 0.001, 0.3, 5.0).has_value());
}

std::optional<Finding> checkConstantRange(double z_m, double metres_per_unit) {
  DepthStatistics statistics;
  for (int i = 0; i < 10; ++i) {
    statistics.add(makeDepth(cv::Mat(30, 40, CV_32FC1, cv::Scalar(z_m)), 1.0));
  }
  return checkDepthRange(statistics, metres_per_unit, 0.3, 5.0);
}

TEST(DepthRange, TabletopsAndRoomsAreSilent) {
  for (const double z_m : {0.35, 0.4, 1.0, 2.5, 4.8}) {
    EXPECT_FALSE(checkConstantRange(z_m, 0.001).has_value()) << z_m;
  }
}

TEST(DepthRange, NamesTheUnitThatBringsTheMedianIntoARoom) {
  const auto expectUnit = [](double median_m, double metres_per_unit, const std::string& unit) {
    const auto finding = checkConstantRange(median_m, metres_per_unit);
    ASSERT_TRUE(finding.has_value()) << median_m;
    EXPECT_EQ(finding->check, "depth range");
    EXPECT_NE(finding->remedy.find("input/depth_scale"), std::string::npos) << finding->remedy;
    EXPECT_NE(finding->remedy.find(unit), std::string::npos) << finding->remedy;
  };
  expectUnit(2000.0, 1.0, "0.001 (millimetres)");  // float depth in millimetres
  expectUnit(0.002, 0.001, "1 (metres)");          // metres taken for millimetres
  expectUnit(20.0, 0.001, "0.0001 (RealSense D405)");
}

TEST(DepthRange, AllUnitsThatMayBeMeantAreNamed) {
  for (const double true_median_m : {1.5, 2.0, 3.0, 4.0, 5.5}) {
    const auto finding = checkConstantRange(4.0 * true_median_m, 0.001);
    ASSERT_TRUE(finding.has_value()) << true_median_m;
    EXPECT_NE(finding->remedy.find("0.00025 (RealSense L515"), std::string::npos)
        << true_median_m << ": " << finding->remedy;
  }
}

TEST(DepthRange, NearlyAllReadingsInvalidIsSaidSo) {
  cv::Mat image(30, 40, CV_16UC1, cv::Scalar(0));
  image.row(0).setTo(1000);
  DepthStatistics statistics;
  for (int i = 0; i < 10; ++i) statistics.add(makeDepth(image, 0.001));
  const auto finding = checkDepthRange(statistics, 0.001, 0.3, 5.0);
  ASSERT_TRUE(finding.has_value());
  EXPECT_EQ(finding->check, "depth range");
  EXPECT_NE(finding->seen.find("97 % of the readings of 10 depth images are invalid"),
            std::string::npos)
      << finding->seen;
}

TEST(DepthRange, FewImagesAreNotEnough) {
  DepthStatistics statistics;
  for (int i = 0; i < 9; ++i) {
    statistics.add(makeDepth(cv::Mat(30, 40, CV_32FC1, cv::Scalar(2000.0)), 1.0));
  }
  EXPECT_FALSE(checkDepthRange(statistics, 1.0, 0.3, 5.0).has_value());
}

TEST(DepthUnits, TheLikelyOneComesFirstAndNoneIsLeftOut) {
  const auto units = findDepthUnits(0.0001, 0.001, 0.00024);
  ASSERT_EQ(units.size(), 5U);
  EXPECT_DOUBLE_EQ(units[0].metres, 0.00025);
  EXPECT_DOUBLE_EQ(units[1].metres, 0.0002);
  EXPECT_NE(listUnits(units).find("0.0001 "), std::string::npos) << listUnits(units);
}

}  // namespace
}  // namespace tsg::plausibility
