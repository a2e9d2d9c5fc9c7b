// SPDX-License-Identifier: BSD-3-Clause
#include "scene_graph/footprint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tsg::scene_graph {
namespace {

Place makePlace(double x_m, double y_m, double clearance_m) {
  Place place;
  place.position_m = {x_m, y_m, 0.5};
  place.clearance_m = clearance_m;
  return place;
}

Footprint computeFootprint(const std::vector<Place>& places) {
  std::vector<const Place*> pointers;
  for (const Place& place : places) pointers.push_back(&place);
  return scene_graph::computeFootprint(pointers);
}

/// Twice the signed area; positive if counter-clockwise.
double computeSignedArea(const std::vector<Eigen::Vector2d>& polygon_m) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon_m.size(); ++i) {
    const Eigen::Vector2d& a = polygon_m[i];
    const Eigen::Vector2d& b = polygon_m[(i + 1) % polygon_m.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

TEST(Footprint, OfOnePlaceIsItsDisc) {
  const Footprint found = computeFootprint({makePlace(-3.0, 7.0, 1.5)});
  EXPECT_NEAR(found.area_m2, M_PI * 1.5 * 1.5, 0.1);
  ASSERT_GE(found.outline_m.size(), 8U);
  for (const Eigen::Vector2d& corner_m : found.outline_m) {
    EXPECT_NEAR((corner_m - Eigen::Vector2d(-3.0, 7.0)).norm(), 1.5, 0.15);
  }
}

TEST(Footprint, RunsCounterClockwise) {
  const Footprint found = computeFootprint({makePlace(0, 0, 1.0), makePlace(1, 0, 1.0)});
  EXPECT_GT(computeSignedArea(found.outline_m), 0.0);
  // Through the centres of the outermost cells: smaller by half a cell all round.
  EXPECT_NEAR(computeSignedArea(found.outline_m), found.area_m2, 0.1 * 8.0);
}

TEST(Footprint, CountsFloorThatSeveralPlacesShareOnce) {
  const Footprint once = computeFootprint({makePlace(0, 0, 1.0)});
  const Footprint twice = computeFootprint({makePlace(0, 0, 1.0), makePlace(0, 0, 1.0)});
  EXPECT_EQ(once.area_m2, twice.area_m2);
}

TEST(Footprint, OutlinesTheLargestOfSeveralParts) {
  const Footprint found = computeFootprint({makePlace(0, 0, 0.5), makePlace(5, 0, 1.0)});
  EXPECT_NEAR(found.area_m2, M_PI * (0.25 + 1.0), 0.15);
  for (const Eigen::Vector2d& corner_m : found.outline_m) EXPECT_GT(corner_m.x(), 3.0);
}

TEST(Footprint, OfPlacesWithoutClearanceHasNoOutline) {
  EXPECT_TRUE(computeFootprint({makePlace(0, 0, 0.0)}).outline_m.empty());
  EXPECT_EQ(scene_graph::computeFootprint({}).area_m2, 0.0);
}

TEST(Footprint, OfPlacesFarApartTakesCoarserCells) {
  const Footprint found = computeFootprint({makePlace(0, 0, 50.0), makePlace(9000, 9000, 50.0)});
  EXPECT_NEAR(found.area_m2, 2 * M_PI * 2500.0, 2000.0);
}

TEST(Footprint, IsTheUnionOfTheDiscsByCells) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> at_m(-2.0, 2.0);
  std::vector<Place> places;
  for (int i = 0; i < 12; ++i) {
    places.push_back(makePlace(at_m(random), at_m(random), 0.4 + 0.2 * at_m(random)));
  }
  int inside = 0;
  constexpr double kFine_m = 0.01;
  for (double x_m = -4.0; x_m < 4.0; x_m += kFine_m) {
    for (double y_m = -4.0; y_m < 4.0; y_m += kFine_m) {
      for (const Place& place : places) {
        if ((place.position_m.head<2>() - Eigen::Vector2d(x_m, y_m)).norm() > place.clearance_m) {
          continue;
        }
        ++inside;
        break;
      }
    }
  }
  EXPECT_NEAR(computeFootprint(places).area_m2, inside * kFine_m * kFine_m, 0.3);
}

}  // namespace
}  // namespace tsg::scene_graph
