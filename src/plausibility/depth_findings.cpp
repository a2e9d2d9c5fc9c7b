// SPDX-License-Identifier: BSD-3-Clause
#include "depth_findings.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tsg::plausibility {
namespace {

constexpr std::uint64_t kMinImages = 10;
constexpr double kMinValidShare = 0.05;
constexpr double kMinShareInRange = 0.2;
constexpr double kUsualMedian_m = 2.0;
constexpr double kLeastMedian_m = 0.4;
constexpr double kGreatestMedian_m = 6.0;

const std::array<DepthUnit, 8>& knownUnits() {
  static const std::array<DepthUnit, 8> units{{{1.0, "metres"},
                                               {0.001, "millimetres"},
                                               {0.01, "centimetres"},
                                               {0.00025, "RealSense L515, 4000 per metre"},
                                               {0.0002, "TUM datasets, 5000 per metre"},
                                               {0.0001, "RealSense D405"},
                                               {1.0 / 6553.5, "Replica, 6553.5 per metre"},
                                               {1.0 / 256.0, "KITTI, 256 per metre"}}};
  return units;
}

std::string describeImages(const DepthStatistics& depth) {
  return std::to_string(depth.numImages()) + " depth images";
}

Finding describeInvalid(const DepthStatistics& depth) {
  return {"depth range",
          formatShare(1.0 - depth.validShare()) + " of the readings of " + describeImages(depth) +
              " are invalid (0, NaN, infinite or the type's largest value)",
          "usually the sensor is covered, nearer or farther than it can measure, or the topic holds"
          " something else than depth",
          "look at the depth image in rviz or rqt_image_view, and check the depth topic"};
}

/// Units that would bring the median to where it may be in a room, the usual first.
std::vector<DepthUnit> findBetterUnits(const DepthStatistics& depth, double metres_per_unit) {
  const double median_units = depth.median_m() / metres_per_unit;
  return findDepthUnits(kLeastMedian_m / median_units, kGreatestMedian_m / median_units,
                        kUsualMedian_m / median_units);
}

Finding describeOutOfRange(const DepthStatistics& depth, double metres_per_unit, double min_range_m,
                           double max_range_m) {
  Finding finding;
  finding.check = "depth range";
  finding.seen = "only " + formatShare(depth.shareWithin(min_range_m, max_range_m)) +
                 " of the valid readings of " + describeImages(depth) + " lie between " +
                 formatNumber(min_range_m) + " and " + formatNumber(max_range_m) +
                 " m, where maps are made of them; the median depth is " +
                 formatNumber(depth.median_m()) + " m with " + formatNumber(metres_per_unit) +
                 " m per unit";
  finding.meaning = "usually the depth unit is wrong";
  const auto units = findBetterUnits(depth, metres_per_unit);
  finding.remedy = "set input/depth_scale (process_bag: --depth-scale), metres per unit";
  if (!units.empty()) finding.remedy += ", to " + listUnits(units);
  finding.remedy += "; if the scene really is so " +
                    std::string(depth.median_m() > max_range_m ? "large" : "near") +
                    ", change the ranges of mesh_fusion";
  return finding;
}

}  // namespace

std::vector<DepthUnit> findDepthUnits(double low_m, double high_m, double likely_m) {
  std::vector<DepthUnit> units;
  for (const DepthUnit& unit : knownUnits()) {
    if (unit.metres >= low_m && unit.metres <= high_m) units.push_back(unit);
  }
  const auto distance = [&](const DepthUnit& unit) {
    return std::abs(std::log(unit.metres / likely_m));
  };
  std::stable_sort(units.begin(), units.end(), [&](const DepthUnit& a, const DepthUnit& b) {
    return distance(a) < distance(b);
  });
  return units;
}

std::string listUnits(const std::vector<DepthUnit>& units) {
  std::string text;
  for (const DepthUnit& unit : units) {
    text += (text.empty() ? "" : " or ") + formatNumber(unit.metres) + " (" + unit.users + ")";
  }
  return text;
}

std::optional<Finding> checkDepthRange(const DepthStatistics& depth, double metres_per_unit,
                                       double min_range_m, double max_range_m) {
  if (depth.numImages() < kMinImages) return std::nullopt;
  if (depth.validShare() < kMinValidShare) return describeInvalid(depth);
  if (depth.shareWithin(min_range_m, max_range_m) >= kMinShareInRange) return std::nullopt;
  return describeOutOfRange(depth, metres_per_unit, min_range_m, max_range_m);
}

}  // namespace tsg::plausibility
