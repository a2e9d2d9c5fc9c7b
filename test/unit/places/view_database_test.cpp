// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/view_database.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "box_world.h"
#include "sparse_config.h"
#include "task_scene_graph/places/place_extractor.h"

namespace tsg::places {
namespace {

using test::BoxWorld;
using test::kVoxel_m;

Embedding makeEmbedding(float a, float b) {
  Embedding embedding(2);
  embedding << a, b;
  return embedding;
}

/// Camera at `at_m` that looks along `yaw_rad` (0 = +x), image x to its right, z up in the world.
Pose lookAlong(const Eigen::Vector3d& at_m, double yaw_rad) {
  Pose pose = Pose::Identity();
  pose.linear().col(2) = Eigen::Vector3d(std::cos(yaw_rad), std::sin(yaw_rad), 0.0);
  pose.linear().col(1) = -Eigen::Vector3d::UnitZ();
  pose.linear().col(0) = pose.linear().col(1).cross(pose.linear().col(2));
  pose.translation() = at_m;
  return pose;
}

/// Frame with depth measured in a closed-form world by marching along each ray.
RgbdFrame render(const BoxWorld& world, const Pose& T_world_camera) {
  RgbdFrame frame;
  frame.camera = {80, 60, 60.0, 60.0, 39.5, 29.5};
  frame.T_world_camera = T_world_camera;
  frame.depth.image = cv::Mat::zeros(60, 80, CV_16UC1);
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 80; ++u) {
      for (double z_m = 0.0; z_m < 12.0;) {
        const double distance_m =
            world.computeDistance(T_world_camera * frame.camera.unproject(u, v, z_m));
        if (distance_m < 0.005) {
          frame.depth.image.at<std::uint16_t>(v, u) =
              static_cast<std::uint16_t>(std::lround(1000.0 * z_m));
          break;
        }
        z_m += distance_m / frame.camera.unproject(u, v, 1.0).norm();
      }
    }
  }
  return frame;
}

/// 3 m in front of a flat wall that fills the view.
View makeWallView(double depth_m = 3.0) {
  RgbdFrame frame;
  frame.camera = {100, 50, 50.0, 50.0, 49.5, 24.5};
  frame.depth.image = cv::Mat(50, 100, CV_16UC1, cv::Scalar(1000.0 * depth_m));
  return makeView(frame, makeEmbedding(1, 0));
}

TEST(View, SeesWhatIsInTheFrustumBeforeTheMeasuredDepth) {
  const View view = makeWallView();
  EXPECT_TRUE(view.sees({0, 0, 2}, 5.0, 0.1));
  EXPECT_TRUE(view.sees({0, 0, 3.05}, 5.0, 0.1));
  EXPECT_FALSE(view.sees({0, 0, 3.15}, 5.0, 0.1));
  EXPECT_FALSE(view.sees({0, 0, -1}, 5.0, 0.1));
  EXPECT_FALSE(view.sees({0, 0, 0}, 5.0, 0.1));
}

TEST(View, EdgesOfTheImageBoundTheFrustum) {
  const View view = makeWallView();
  // At 1 m depth the image spans x in [-1, 1] and y in [-0.5, 0.5].
  EXPECT_TRUE(view.sees({0.995, 0, 1}, 5.0, 0.1));
  EXPECT_FALSE(view.sees({1.005, 0, 1}, 5.0, 0.1));
  EXPECT_TRUE(view.sees({-0.995, -0.495, 1}, 5.0, 0.1));
  EXPECT_FALSE(view.sees({-1.005, 0, 1}, 5.0, 0.1));
  EXPECT_FALSE(view.sees({0, 0.505, 1}, 5.0, 0.1));
  EXPECT_FALSE(view.sees({0, -0.505, 1}, 5.0, 0.1));
}

TEST(View, RangeIsMeasuredFromTheCameraCentre) {
  const View view = makeWallView();
  EXPECT_TRUE(view.sees({0, 0, 1.4}, 1.5, 0.1));
  EXPECT_FALSE(view.sees({1.2, 0, 1.4}, 1.5, 0.1));
}

TEST(View, NothingMeasuredHidesNothing) {
  RgbdFrame frame;
  frame.camera = {100, 50, 50.0, 50.0, 49.5, 24.5};
  frame.depth.image =
      cv::Mat(50, 100, CV_32FC1, cv::Scalar(std::numeric_limits<double>::quiet_NaN()));
  frame.depth.metres_per_unit = 1.0;
  EXPECT_TRUE(makeView(frame, makeEmbedding(1, 0)).sees({0, 0, 4}, 5.0, 0.1));
}

TEST(View, MedianOfATileIgnoresFlyingAndInvalidPixels) {
  RgbdFrame frame;
  frame.camera = {16, 8, 50.0, 50.0, 7.5, 3.5};
  frame.depth.image = cv::Mat(8, 16, CV_16UC1, cv::Scalar(3000));
  frame.depth.image(cv::Rect(0, 0, 8, 3)).setTo(0);
  frame.depth.image(cv::Rect(0, 3, 8, 2)).setTo(500);
  const View view = makeView(frame, makeEmbedding(1, 0));
  ASSERT_EQ(view.depth_mm.size(), 2U);
  EXPECT_EQ(view.depth_mm[0], 3000);
}

TEST(View, PoseMapsCameraToWorld) {
  RgbdFrame frame;
  frame.camera = {100, 50, 50.0, 50.0, 49.5, 24.5};
  frame.depth.image = cv::Mat(50, 100, CV_16UC1, cv::Scalar(3000));
  frame.T_world_camera = lookAlong({1, 2, 1}, M_PI / 2);
  const View view = makeView(frame, makeEmbedding(1, 0));
  EXPECT_TRUE(view.sees({1, 4, 1}, 5.0, 0.1));
  EXPECT_FALSE(view.sees({1, 0, 1}, 5.0, 0.1));
  EXPECT_FALSE(view.sees({3, 2, 1}, 5.0, 0.1));
}

TEST(ViewDatabase, ForgetsTheOldestViewFirst) {
  ViewDatabase views(2, 5.0, 0.1);
  for (const float value : {1.0F, 2.0F, 4.0F}) {
    View view = makeWallView();
    view.embedding = makeEmbedding(value, 0);
    views.add(std::move(view));
  }
  EXPECT_EQ(views.size(), 2U);
  EXPECT_EQ(views.numForgotten(), 1U);
  const ViewSum sum = views.collect({0, 0, 2});
  EXPECT_EQ(sum.count, 2U);
  EXPECT_TRUE(sum.computeMean().isApprox(makeEmbedding(3, 0)));
}

/// Two rooms of 4 x 4 m apart but for a door at y = 1.5 .. 2.3.
struct TwoRooms {
  TwoRooms() : volume(kVoxel_m) {
    world.addRoom(0, 0, 8.2, 4);
    world.add({4, 0, 0}, {4.2, 1.5, 2.5}).add({4, 2.3, 0}, {4.2, 4, 2.5});
    blocks = test::observe(world, makeAabb({-1, -1, -0.5}, {9, 5, 2.4}), volume);
  }

  BoxWorld world;
  mapping::TsdfVolume volume;
  std::vector<mapping::GridIndex> blocks;
};

TEST(PlaceFeatures, WallHidesThePlacesBehindIt) {
  const TwoRooms rooms;
  PlaceExtractor extractor{makeSparseConfig()};
  extractor.update(rooms.volume, rooms.blocks, Stamp{1});
  // From the left room's corner the view goes against the wall, away from the door.
  const RgbdFrame frame = render(rooms.world, lookAlong({0.6, 3.4, 1.2}, -0.1));
  extractor.addView(frame, makeEmbedding(1, 2));
  int num_seen = 0;
  int num_hidden = 0;
  for (const Place& place : extractor.graph().places) {
    const bool is_beyond = place.position_m.x() > 4.3;
    const Eigen::Vector3d p_camera = frame.T_world_camera.inverse() * place.position_m;
    const Eigen::Vector2d pixel = frame.camera.project(p_camera);
    const bool is_in_frustum = p_camera.z() > 0.0 && p_camera.norm() < 5.0 &&
                               pixel.minCoeff() > 0 && pixel.x() < 79 && pixel.y() < 59;
    num_hidden += is_in_frustum && place.num_views == 0 ? 1 : 0;
    num_seen += place.num_views == 1 ? 1 : 0;
    EXPECT_TRUE(!is_beyond || place.position_m.y() < 2.5 || place.num_views == 0U);
    EXPECT_TRUE(!is_in_frustum || place.position_m.x() > 3.9 || place.num_views == 1U);
    EXPECT_EQ(place.embedding.size(), place.num_views == 0 ? 0 : 2);
  }
  EXPECT_GE(num_seen, 2);
  EXPECT_GE(num_hidden, 1);
}

class WeightedFeatures : public ::testing::TestWithParam<ViewWeighting> {};
INSTANTIATE_TEST_SUITE_P(Weightings, WeightedFeatures,
                         ::testing::Values(ViewWeighting::kAverage, ViewWeighting::kClosest,
                                           ViewWeighting::kInverseSquare));

/// The feature of a point from all views at once; with how many see it.
std::pair<Embedding, std::uint32_t> computeFeature(const std::vector<View>& views,
                                                   const Eigen::Vector3d& p_world,
                                                   ViewWeighting weighting) {
  Eigen::Vector2d sum(0, 0);
  double total = 0.0;
  double nearest_m = std::numeric_limits<double>::infinity();
  std::uint32_t count = 0;
  for (const View& view : views) {
    if (!view.sees(p_world, 5.0, 0.1)) continue;
    ++count;
    const double distance_m = (view.T_camera_world * p_world).norm();
    double weight = 1.0;
    if (weighting == ViewWeighting::kInverseSquare) {
      weight = 1.0 / std::pow(std::max(distance_m, 0.5), 2);
    }
    if (weighting == ViewWeighting::kClosest) {
      if (distance_m >= nearest_m) continue;
      nearest_m = distance_m;
      sum.setZero();
      total = 0.0;
    }
    sum += weight * view.embedding.cast<double>();
    total += weight;
  }
  return {(sum / total).cast<float>(), count};
}

TEST_P(WeightedFeatures, EqualThoseOfAllViewsAtOnceWhateverCameFirst) {
  const TwoRooms rooms;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> x_m(0.5, 3.5);
  std::uniform_real_distribution<double> yaw_rad(-3.1, 3.1);
  std::normal_distribution<float> normal;
  PlacesConfig config = makeSparseConfig();
  config.view_weighting = GetParam();
  PlaceExtractor places_first{config};
  places_first.update(rooms.volume, rooms.blocks, Stamp{1});
  PlaceExtractor views_first{config};
  std::vector<View> views;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d at_m(x_m(random) + (i % 2 == 0 ? 4.2 : 0.0), x_m(random), 1.2);
    const RgbdFrame frame = render(rooms.world, lookAlong(at_m, yaw_rad(random)));
    const Embedding embedding = makeEmbedding(normal(random), normal(random));
    places_first.addView(frame, embedding);
    views_first.addView(frame, embedding);
    views.push_back(makeView(frame, embedding));
  }
  views_first.update(rooms.volume, rooms.blocks, Stamp{1});
  const PlaceGraph graph = places_first.graph();
  std::uint32_t num_views = 0;
  for (std::size_t i = 0; i < graph.places.size(); ++i) {
    const Place& place = graph.places[i];
    const auto [feature, count] = computeFeature(views, place.position_m, GetParam());
    ASSERT_EQ(place.num_views, count);
    ASSERT_EQ(views_first.graph().places[i].num_views, count);
    num_views += count;
    if (count == 0) continue;
    EXPECT_TRUE(place.embedding->isApprox(feature, 1e-4F));
    EXPECT_EQ(views_first.graph().places[i].embedding, place.embedding);
  }
  EXPECT_GT(num_views, 40U);
}

TEST(Features, ThatNoViewHasChangedAreSharedByGraphs) {
  const TwoRooms rooms;
  PlaceExtractor extractor{makeSparseConfig()};
  extractor.update(rooms.volume, rooms.blocks, Stamp{1});
  extractor.addView(render(rooms.world, lookAlong({1.0, 2.0, 1.2}, 0.0)), makeEmbedding(1, 0));
  const PlaceGraph before = extractor.graph();
  extractor.addView(render(rooms.world, lookAlong({5.2, 2.0, 1.2}, 0.0)), makeEmbedding(0, 1));
  const PlaceGraph after = extractor.graph();
  ASSERT_EQ(after.places.size(), before.places.size());
  int num_shared = 0;
  int num_changed = 0;
  for (std::size_t i = 0; i < after.places.size(); ++i) {
    const bool is_shared = &*after.places[i].embedding == &*before.places[i].embedding;
    EXPECT_EQ(is_shared, after.places[i].num_views == before.places[i].num_views);
    if (after.places[i].num_views == 0) continue;
    ++(is_shared ? num_shared : num_changed);
  }
  EXPECT_GT(num_shared, 0);
  EXPECT_GT(num_changed, 0);
}

TEST(ViewSum, OfTheClosestKeepsTheFirstOfViewsEquallyNear) {
  ViewSum sum;
  sum.add(makeEmbedding(1, 0), 2.0, ViewWeighting::kClosest);
  sum.add(makeEmbedding(0, 1), 2.0, ViewWeighting::kClosest);
  EXPECT_EQ(sum.computeMean(), makeEmbedding(1, 0));
  EXPECT_EQ(sum.count, 2U);
  sum.add(makeEmbedding(0, 1), 1.5, ViewWeighting::kClosest);
  EXPECT_EQ(sum.computeMean(), makeEmbedding(0, 1));
}

TEST(ViewSum, DoesNotCountViewsNearerThanHalfAMetreForMore) {
  EXPECT_EQ(computeViewWeight(0.1, ViewWeighting::kInverseSquare),
            computeViewWeight(0.5, ViewWeighting::kInverseSquare));
  EXPECT_EQ(computeViewWeight(2.0, ViewWeighting::kInverseSquare), 0.25);
}

/// In a room beside a door: a place is like its own room though most views look in from outside.
TEST(PlaceFeatures, BelongToTheirOwnRoomIfViewsCountBySolidAngle) {
  const auto view = [](float own, double distance_m, ViewSum& sum, ViewWeighting weighting) {
    sum.add(makeEmbedding(own, 1.0F - own), distance_m, weighting);
  };
  for (const ViewWeighting weighting : {ViewWeighting::kAverage, ViewWeighting::kInverseSquare}) {
    ViewSum sum;
    for (int i = 0; i < 6; ++i) view(0.2F, 4.0, sum, weighting);  // through the door
    for (int i = 0; i < 2; ++i) view(0.9F, 1.0, sum, weighting);  // in the room
    const Embedding mean = sum.computeMean();
    EXPECT_EQ(mean[0] > mean[1], weighting == ViewWeighting::kInverseSquare);
  }
}

TEST(PlaceFeatures, UnusableViewsAreIgnoredAndCounted) {
  const TwoRooms rooms;
  PlaceExtractor extractor{makeSparseConfig()};
  const RgbdFrame good = render(rooms.world, lookAlong({2, 2, 1.2}, 0.0));
  extractor.addView(good, makeEmbedding(1, 0));
  extractor.addView(good, Embedding());
  extractor.addView(good, makeEmbedding(0, 0));
  extractor.addView(good, makeEmbedding(NAN, 0));
  extractor.addView(good, Embedding::Ones(3));
  RgbdFrame bad_pose = good;
  bad_pose.T_world_camera.translation().x() = NAN;
  extractor.addView(bad_pose, makeEmbedding(1, 0));
  RgbdFrame bad_depth = good;
  bad_depth.depth.image = cv::Mat::zeros(10, 10, CV_16UC1);
  extractor.addView(bad_depth, makeEmbedding(1, 0));
  EXPECT_EQ(extractor.counters().views, 1U);
  EXPECT_EQ(extractor.counters().ignored_views, 6U);
}

}  // namespace
}  // namespace tsg::places
