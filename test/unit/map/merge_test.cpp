// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/map/merge.h"

#include <gtest/gtest.h>

#include <set>

#include "support.h"
#include "task_scene_graph/map/files.h"
#include "walk.h"

namespace tsg::map {
namespace {

using test::compareObjects;
using test::makeWalkMap;

constexpr int kHalf = test::kWalkFrames / 2;

std::string errorOf(const Map& a, const Map& b, const MergeOptions& options) {
  try {
    mergeMaps(a, b, options);
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

std::set<std::uint64_t> listIds(const Map& map) {
  std::set<std::uint64_t> ids;
  for (const auto& primitive : map.primitives()) ids.insert(primitive->id.value);
  return ids;
}

class HalfWalks : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    whole_ = makeWalkMap(0, test::kWalkFrames);
    a_ = makeWalkMap(0, kHalf);
    b_ = makeWalkMap(kHalf, test::kWalkFrames);
  }
  static void TearDownTestSuite() { whole_ = a_ = b_ = nullptr; }

  static MapPtr whole_, a_, b_;
};

MapPtr HalfWalks::whole_, HalfWalks::a_, HalfWalks::b_;

TEST_F(HalfWalks, MergedHaveTheObjectsOfOneRun) {
  const Map merged = mergeMaps(*a_, *b_, {});
  EXPECT_EQ(compareObjects(computeSceneGraph(merged), computeSceneGraph(*whole_), 0.7), "");
  EXPECT_EQ(computeSceneGraph(merged).objects.size(), 2U);  // both saw both
}

TEST_F(HalfWalks, IdsAreRemappedAndTheRecordSaysFromWhere) {
  MergeOptions options;
  options.name_b = "second half";
  const Map merged = mergeMaps(*a_, *b_, options);
  EXPECT_EQ(merged.primitives().size(), a_->primitives().size() + b_->primitives().size());
  ASSERT_EQ(merged.sources().size(), 1U);
  const MapSource& source = merged.sources().front();
  EXPECT_EQ(source.name, "second half");
  for (const auto& primitive : b_->primitives()) {
    const auto here = merged.findPrimitive({primitive->id.value + source.primitive_id_offset});
    ASSERT_NE(here, nullptr);
    EXPECT_EQ(here->embedding, primitive->embedding);
    EXPECT_LE(here->id.value, source.max_primitive_id);
  }
  for (const auto& primitive : a_->primitives()) {
    EXPECT_EQ(merged.findPrimitive(primitive->id), primitive);
  }
}

TEST_F(HalfWalks, ObjectsOfTheFirstKeepTheirIds) {
  const auto before = computeSceneGraph(*a_);
  const auto after = computeSceneGraph(mergeMaps(*a_, *b_, {}));
  for (const auto& object : before.objects) {
    const auto same = std::find_if(after.objects.begin(), after.objects.end(),
                                   [&](const auto& other) { return other.id == object.id; });
    ASSERT_NE(same, after.objects.end());
    EXPECT_EQ(same->task, object.task);
  }
}

TEST_F(HalfWalks, PlacesAreThoseOfBothTogether) {
  const Map merged = mergeMaps(*a_, *b_, {});
  const auto count = static_cast<double>(whole_->places()->places.size());
  EXPECT_NEAR(static_cast<double>(merged.places()->places.size()), count, 0.25 * count + 2.0);
  EXPECT_FALSE(merged.placeMemory()->plan.tiles().empty());
  const auto countSeen = [](const Map& map) {
    const auto& places = map.places()->places;
    return static_cast<double>(std::count_if(places.begin(), places.end(),
                                             [](const Place& p) { return p.num_views > 0; }));
  };
  EXPECT_NEAR(countSeen(merged), countSeen(*whole_), 0.25 * countSeen(*whole_) + 2.0);
}

TEST_F(HalfWalks, TheMeshHasNoSurfaceTwice) {
  const Map merged = mergeMaps(*a_, *b_, {});
  const auto count = [](const Map& map) { return computeMesh(map).triangles.size(); };
  EXPECT_LT(count(merged), 1.15 * static_cast<double>(count(*whole_)));
  EXPECT_GT(count(merged), 0.85 * static_cast<double>(count(*whole_)));
}

TEST_F(HalfWalks, AMapInOtherCoordinatesIsMovedByTheTransform) {
  Pose T_b_a = Pose::Identity();
  T_b_a.linear() = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_b_a.translation() = Eigen::Vector3d(12.0, -3.0, 0.2);
  const MapPtr elsewhere = makeWalkMap(kHalf, test::kWalkFrames, false, T_b_a);
  MergeOptions options;
  options.T_a_b = T_b_a.inverse();
  options.is_transform_given = true;
  const Map merged = mergeMaps(*a_, *elsewhere, options);
  EXPECT_EQ(compareObjects(computeSceneGraph(merged), computeSceneGraph(*whole_), 0.5), "");
  for (const Place& place : merged.places()->places) {
    EXPECT_LT(place.position_m.head<2>().norm(), 4.5);
  }
  const Pose first = merged.trajectory()->poses().rbegin()->second;
  EXPECT_TRUE(first.isApprox(whole_->trajectory()->poses().rbegin()->second, 1e-9));
}

TEST_F(HalfWalks, AMergedMapIsSavedLoadedAndMergedOn) {
  MergeOptions options;
  options.name_b = "b";
  const test::TemporaryFolder folder;
  writeMap(folder.path() / "merged", mergeMaps(*a_, *b_, options));
  const Map loaded = loadMap(folder.path() / "merged").map;
  options.name_b = "merged";
  const MapPtr again = makeWalkMap(0, kHalf, false, Pose::Identity(), 500.0);
  const Map both = mergeMaps(*again, loaded, options);
  ASSERT_EQ(both.sources().size(), 2U);
  EXPECT_EQ(both.sources()[0].name, "merged");
  EXPECT_EQ(both.sources()[1].name, "b");
  EXPECT_GT(both.sources()[1].primitive_id_offset, both.sources()[0].primitive_id_offset);
  EXPECT_EQ(computeSceneGraph(both).objects.size(), 2U);
  EXPECT_EQ(listIds(both).size(), both.primitives().size());
}

TEST_F(HalfWalks, MergedWithItselfAMapHasTheSameObjects) {
  const Map twice = mergeMaps(*whole_, *whole_, {});
  EXPECT_EQ(compareObjects(computeSceneGraph(twice), computeSceneGraph(*whole_), 0.9), "");
  EXPECT_EQ(twice.places()->places.size(), whole_->places()->places.size());
}

TEST_F(HalfWalks, WhatCannotBeMergedIsNamed) {
  const Map other_frame = [] {
    Map map("map");
    map.addPrimitives(a_->primitives());
    return map;
  }();
  EXPECT_NE(errorOf(*a_, other_frame, {}).find("'map', expected 'odom'"), std::string::npos);
  MergeOptions given;
  given.is_transform_given = true;
  EXPECT_EQ(errorOf(*a_, other_frame, given), "");
  given.T_a_b.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_NE(errorOf(*a_, *b_, given).find("tilts by 17"), std::string::npos)
      << errorOf(*a_, *b_, given);

  const auto withModelSet = [](const Map& map, const std::string& name) {
    Map changed = map;
    MapSettings settings = map.settings();
    settings.model_set = name;
    changed.setSettings(settings);
    return changed;
  };
  EXPECT_NE(errorOf(withModelSet(*a_, "x"), withModelSet(*b_, "y"), {}).find("'y', expected 'x'"),
            std::string::npos);

  Map other_size("odom");
  auto primitive = std::make_shared<ObjectPrimitive>(*a_->primitives().front());
  primitive->embedding = Embedding::Unit(7, 0);
  other_size.addPrimitives({primitive});
  EXPECT_NE(errorOf(*a_, other_size, {}).find("size 7, expected 4"), std::string::npos);
}

}  // namespace
}  // namespace tsg::map
