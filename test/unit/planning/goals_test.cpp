// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/planning/goals.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace tsg::planning {
namespace {

scene_graph::SceneGraph makeGraph() {
  scene_graph::SceneGraph graph;
  graph.objects.resize(3);
  for (std::size_t i = 0; i < 3; ++i) {
    graph.objects[i].id = ObjectId{2 * i + 1};
    graph.objects[i].task = i < 2 ? "cup" : "chair";
    graph.objects[i].score = 0.2 + 0.1 * static_cast<double>(i);
    graph.objects[i].box = makeAabb({0, 0, 0}, {1, 2, 1});
  }
  graph.objects[1].oriented_box = {{3, 3, 3}, {1, 1, 1}, 0.3};
  graph.regions.resize(1);
  graph.regions[0].id = RegionId{4};
  graph.regions[0].task = "kitchen";
  graph.regions[0].position_m = {7, 8, 0.5};
  return graph;
}

/// What the exception says.
template <typename Function>
std::string explain(const Function& f) {
  try {
    f();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

TEST(Goals, AnObjectIsItsOrientedBoxOrElseItsAlignedOne) {
  const auto graph = makeGraph();
  EXPECT_DOUBLE_EQ(findObjectGoal(graph, ObjectId{3}).object->yaw_rad, 0.3);
  EXPECT_DOUBLE_EQ(findObjectGoal(graph, ObjectId{1}).object->center_m.y(), 1.0);
}

TEST(Goals, ARegionIsItsCentralPlace) {
  EXPECT_DOUBLE_EQ(findRegionGoal(makeGraph(), RegionId{4}).position_m.x(), 7.0);
  EXPECT_FALSE(findRegionGoal(makeGraph(), RegionId{4}).object.has_value());
}

TEST(Goals, ANameIsThatOfTheBestObject) {
  EXPECT_EQ(findObject(makeGraph(), "cup"), ObjectId{3});
  EXPECT_EQ(findRegion(makeGraph(), "kitchen"), RegionId{4});
}

TEST(Goals, WhatIsNotThereIsNamedWithWhatIs) {
  const auto graph = makeGraph();
  EXPECT_EQ(explain([&] { findObjectGoal(graph, ObjectId{9}); }),
            "no object has the id 9: there are 3, with ids from 1 to 5");
  EXPECT_EQ(explain([&] { findPlaceGoal(PlaceGraph{}, PlaceId{9}); }),
            "no place has the id 9: there is none");
  EXPECT_EQ(explain([&] { findObject(graph, "sofa"); }),
            "no object is named 'sofa': there are: chair, cup");
  EXPECT_EQ(explain([&] { findRegion(scene_graph::SceneGraph{}, "bath"); }),
            "no region is named 'bath': none has a name");
}

}  // namespace
}  // namespace tsg::planning
