// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/plausibility/embedding_checks.h"

#include <gtest/gtest.h>

namespace tsg::plausibility {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

CosineContext makeContext(std::size_t num_served) {
  CosineContext context;
  context.tasks = {"wash the dishes", "read a book"};
  context.num_served = num_served;
  return context;
}

TEST(Cosines, ObjectsOrFewPrimitivesAreSilent) {
  EXPECT_FALSE(checkCosines({300, 0.30, 0, 0.20, 0.10}, makeContext(7)).has_value());
  EXPECT_FALSE(checkCosines({4, 0.10, 0, 0.08, 0.05}, makeContext(0)).has_value());
  EXPECT_FALSE(checkCosines({}, makeContext(0)).has_value());
}

TEST(Cosines, TheHighestOneIsHeldAgainstAlpha) {
  const auto finding = checkCosines({120, 0.11, 1, 0.08, 0.02}, makeContext(0));
  ASSERT_TRUE(finding.has_value());
  EXPECT_EQ(finding->check, "cosines");
  EXPECT_TRUE(contains(finding->seen, "none of 120 primitives reaches object_alpha 0.23"));
  EXPECT_TRUE(contains(finding->seen, "the highest cosine was 0.11 (task 'read a book')"));
  EXPECT_TRUE(contains(finding->remedy, "scene_graph/object_alpha"));
}

TEST(Cosines, ThoseOfPlacesHaveTheirOwnKey) {
  CosineContext context = makeContext(0);
  context.things = "place";
  context.parameter = "place_alpha";
  context.alpha = 0.21;
  const auto finding = checkCosines({30, 0.15, 0, 0.08, 0.02}, context);
  ASSERT_TRUE(finding.has_value());
  EXPECT_EQ(finding->check, "place cosines");
  EXPECT_TRUE(contains(finding->remedy, "scene_graph/place_alpha"));
}

TEST(Cosines, AllFarAboveAlphaIsNamedToo) {
  const auto finding = checkCosines({120, 0.92, 1, 0.80, 0.61}, makeContext(90));
  ASSERT_TRUE(finding.has_value());
  EXPECT_TRUE(contains(finding->seen, "between 0.61 and 0.92"));
}

TEST(Cosines, AnEmptyListOfTasksIsNamed) {
  CosineContext context = makeContext(0);
  context.tasks.clear();
  const auto finding = checkCosines({}, context);
  ASSERT_TRUE(finding.has_value());
  EXPECT_EQ(finding->check, "no tasks");
}

TEST(Cosines, TheContextOfAGraphTakesTheHigherThreshold) {
  scene_graph::SceneGraph graph;
  graph.object_tasks = {"a"};
  graph.objects.resize(2);
  EXPECT_EQ(makeObjectContext(graph).parameter, "object_alpha");
  EXPECT_DOUBLE_EQ(makeObjectContext(graph).alpha, graph.config.object_alpha);
  EXPECT_EQ(makeObjectContext(graph).num_served, 2U);
  graph.config.min_object_score = 0.5;
  EXPECT_EQ(makeObjectContext(graph).parameter, "min_object_score");
  EXPECT_DOUBLE_EQ(makeObjectContext(graph).alpha, 0.5);
}

TEST(Cosines, RegionsWithoutATaskAreNotServed) {
  scene_graph::SceneGraph graph;
  graph.place_tasks = {"a"};
  graph.regions.resize(3);
  graph.regions[1].task_index = 0;
  EXPECT_EQ(makePlaceContext(graph).num_served, 1U);
  EXPECT_EQ(makePlaceContext(graph).things, "place");
}

tracking::TrackerCounters makeCounters(std::uint64_t overlapping, double refused_cosine,
                                       std::uint64_t refused) {
  tracking::TrackerCounters counters;
  counters.overlapping_segments = overlapping;
  counters.refused_by_cosine = refused;
  for (std::uint64_t i = 0; i < overlapping; ++i) {
    counters.overlap_cosines.add(i < refused ? refused_cosine : 0.95);
  }
  return counters;
}

TEST(TrackerCosines, FewRefusalsAreSilent) {
  EXPECT_FALSE(checkTracker(makeCounters(1000, 0.7, 300), {}).has_value());
  EXPECT_FALSE(checkTracker(makeCounters(50, 0.7, 50), {}).has_value());
}

TEST(TrackerCosines, ManyRefusalsNameAThresholdThatWouldFit) {
  const auto finding = checkTracker(makeCounters(1000, 0.71, 830), {});
  ASSERT_TRUE(finding.has_value());
  EXPECT_EQ(finding->check, "tracker cosines");
  EXPECT_TRUE(contains(finding->seen, "of 1000 segments"));
  EXPECT_TRUE(contains(finding->seen, "83 % were refused by their cosine alone"));
  EXPECT_TRUE(contains(finding->seen, "min_cosine 0.9"));
  EXPECT_TRUE(contains(finding->remedy, "tracker/min_cosine to about 0.7"));
  EXPECT_TRUE(contains(finding->remedy, "khronos"));
}

}  // namespace
}  // namespace tsg::plausibility
