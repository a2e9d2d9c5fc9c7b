// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/question_markers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "task_scene_graph/ros/marker_colors.h"

namespace tsg::ros_interface {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

std::vector<Marker> find(const MarkerArray& array, const std::string& ns) {
  std::vector<Marker> found;
  std::copy_if(array.markers.begin(), array.markers.end(), std::back_inserter(found),
               [&](const Marker& marker) { return marker.ns == ns; });
  return found;
}

Embedding directionOf(double cosine) {
  Embedding embedding(2);
  embedding << static_cast<float>(cosine), static_cast<float>(std::sqrt(1.0 - cosine * cosine));
  return embedding;
}

/// Primitive i (from 1) has the cosine i / (count + 1) to the first axis and is at x = i; the first
/// is an object.
scene_graph::SceneGraph makeGraph(std::size_t count) {
  scene_graph::SceneGraph graph;
  graph.world_frame = "map";
  graph.places = std::make_shared<PlaceGraph>();
  for (std::size_t i = 1; i <= count; ++i) {
    auto primitive = std::make_shared<ObjectPrimitive>();
    primitive->id = {i};
    const double x_m = static_cast<double>(i);
    primitive->box = makeAabb({x_m - 0.25, 0, 0}, {x_m + 0.25, 1, 2});
    primitive->oriented_box = toOrientedBox(primitive->box);
    primitive->embedding = directionOf(x_m / static_cast<double>(count + 1));
    graph.primitives.push_back(primitive);
  }
  if (count == 0) return graph;
  scene_graph::SceneObject object;
  object.id = {70};
  object.box = graph.primitives.front()->box;
  object.oriented_box = graph.primitives.front()->oriented_box;
  object.embedding = graph.primitives.front()->embedding;
  object.primitives = {{1}};
  graph.objects = {object};
  return graph;
}

MarkerArray makeMarkers(const scene_graph::SceneGraph& graph, const std::string& asked) {
  const auto scores = scene_graph::scoreQuestion(graph, Embedding::Unit(2, 0));
  return makeQuestionMarkers(graph, scores, asked);
}

TEST(QuestionMarkers, TheBestIsRedAndTheLeastIsBlueAtTheirBoxes) {
  const MarkerArray array = makeMarkers(makeGraph(3), "mug");
  EXPECT_EQ(array.markers.front().action, Marker::DELETEALL);
  const auto objects = find(array, "question_objects");
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0].id, 70);
  EXPECT_EQ(objects[0].color.b, 1.0F);
  EXPECT_EQ(objects[0].color.r, 0.0F);
  EXPECT_DOUBLE_EQ(objects[0].pose.position.x, 1.0);
  EXPECT_NEAR(objects[0].scale.z, 2.0, 0.03);
  const auto primitives = find(array, "question_primitives");
  ASSERT_EQ(primitives.size(), 2U);  // the third is the object's
  EXPECT_EQ(primitives[0].id, 3);
  EXPECT_EQ(primitives[0].color.r, 1.0F);
  EXPECT_EQ(primitives[0].color.b, 0.0F);
  EXPECT_GT(primitives[1].color.g, 0.9F);  // half way
  EXPECT_TRUE(find(array, "question_others").empty());
}

TEST(QuestionMarkers, TheLegendSaysWhatWasAskedAndWhatTheColoursMean) {
  const MarkerArray array = makeMarkers(makeGraph(3), "mug");
  const auto legend = find(array, "question_legend");
  ASSERT_EQ(legend.size(), 1U);
  EXPECT_EQ(legend[0].text, "'mug': blue 0.25, red 0.75");
  const auto labels = find(array, "question_labels");
  ASSERT_EQ(labels.size(), 3U);
  EXPECT_EQ(labels[0].text, "0.75");
  EXPECT_EQ(labels[2].text, "0.25");
  EXPECT_GT(labels[0].pose.position.z, 2.0);  // above the box
}

TEST(QuestionMarkers, WhatIsBeyondTheBestIsADot) {
  const std::size_t count = kMaxQuestionBoxes + 11;
  const MarkerArray array = makeMarkers(makeGraph(count), "");
  EXPECT_EQ(find(array, "question_primitives").size(), kMaxQuestionBoxes);
  const auto dots = find(array, "question_others");
  ASSERT_EQ(dots.size(), 1U);
  EXPECT_EQ(dots[0].points.size(), 10U);
  EXPECT_EQ(dots[0].colors.size(), 10U);
  EXPECT_EQ(dots[0].points.back().x, 2.0);  // the least, but for the object
  EXPECT_EQ(find(array, "question_labels").size(), kNumQuestionLabels);
}

TEST(QuestionMarkers, OfNothingOnlyWhatWasThereIsDeleted) {
  const MarkerArray array = makeMarkers(makeGraph(0), "mug");
  ASSERT_EQ(array.markers.size(), 1U);
  EXPECT_EQ(array.markers[0].action, Marker::DELETEALL);
}

TEST(MarkerColors, ScoresGoFromBlueOverGreenToRed) {
  const auto low = computeScoreColor(-1.0, 0.5F);
  const auto middle = computeScoreColor(0.5, 0.5F);
  const auto high = computeScoreColor(2.0, 0.5F);
  EXPECT_EQ(std::make_tuple(low.r, low.g, low.b), std::make_tuple(0.0F, 0.0F, 1.0F));
  EXPECT_EQ(std::make_tuple(middle.r, middle.g, middle.b), std::make_tuple(0.0F, 1.0F, 0.0F));
  EXPECT_EQ(std::make_tuple(high.r, high.g, high.b), std::make_tuple(1.0F, 0.0F, 0.0F));
  EXPECT_EQ(high.a, 0.5F);
}

double distanceOf(const std_msgs::ColorRGBA& a, const std_msgs::ColorRGBA& b) {
  return std::hypot(static_cast<double>(a.r - b.r), static_cast<double>(a.g - b.g),
                    static_cast<double>(a.b - b.b));
}

TEST(MarkerColors, NoColourOfARegionIsThatOfAnotherOrOfATask) {
  for (int i = 0; i < kNumRegionColors; ++i) {
    const auto color = computeRegionColor(i, 1.0F);
    for (int k = 0; k < i; ++k) EXPECT_GT(distanceOf(color, computeRegionColor(k, 1.0F)), 0.15);
    for (int task = -1; task < 30; ++task) {
      EXPECT_GT(distanceOf(color, computeColor(task, 1.0F)), 0.15) << i << " " << task;
    }
  }
}

TEST(MarkerColors, ARegionGetsAColourThatNoneNearbyHas) {
  scene_graph::SceneGraph graph;
  std::map<RegionId, int> colors;
  for (std::uint64_t i = 0; i < 40; ++i) {  // on a grid of 8 by 5, ids 13 apart
    scene_graph::Region region;
    region.id = {1 + 13 * i};
    region.position_m = {4.0 * static_cast<double>(i % 8), 4.0 * static_cast<double>(i / 8), 1.0};
    graph.regions.push_back(region);
    colors[region.id] = chooseRegionColor(graph, region, colors);
  }
  for (const auto& a : graph.regions) {
    for (const auto& b : graph.regions) {
      const double distance_m = (a.position_m - b.position_m).norm();
      if (a.id == b.id || distance_m > 6.0) continue;
      EXPECT_NE(colors[a.id], colors[b.id]) << a.id.value << " " << b.id.value;
    }
  }
}

}  // namespace
}  // namespace tsg::ros_interface
