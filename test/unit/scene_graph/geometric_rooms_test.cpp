// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/geometric_rooms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace tsg::scene_graph {
namespace {

using Ids = std::vector<PlaceId>;
using Pairs = std::vector<std::pair<double, std::size_t>>;

/// Places 0.. of the cases have ids 1..
PlaceGraph makeGraph(std::size_t num_places, double clearance_m,
                     const std::vector<std::tuple<std::uint64_t, std::uint64_t, double>>& edges) {
  PlaceGraph graph;
  for (std::size_t i = 0; i < num_places; ++i) {
    graph.places.push_back({{i + 1}, {static_cast<double>(i), 0, 0}, clearance_m, {}, 0});
  }
  for (const auto& [a, b, width_m] : edges) graph.edges.push_back({{a + 1}, {b + 1}, width_m});
  return graph;
}

Pairs toPairs(const std::vector<FiltrationStep>& steps) {
  Pairs pairs;
  for (const auto& step : steps) pairs.emplace_back(step.dilation_m, step.num_components);
  return pairs;
}

TEST(Filtration, CountsTheComponentsAfterEachEdge) {
  const PlaceGraph graph = makeGraph(4, 1.0, {{0, 1, .4}, {1, 2, .5}, {2, 3, .6}});
  EXPECT_EQ(toPairs(computeFiltration(graph, 1, -1.0)), (Pairs{{.4, 1}, {.5, 2}, {.6, 3}}));
}

TEST(Filtration, ReplacesTheCountOfAnEdgeNearerThanTheStep) {
  const PlaceGraph graph = makeGraph(4, 1.0, {{0, 1, .4}, {1, 2, .55}, {2, 3, .6}});
  EXPECT_EQ(toPairs(computeFiltration(graph, 1, 0.1)), (Pairs{{.4, 1}, {.6, 2}}));
}

std::vector<FiltrationStep> makeCounts(const std::vector<std::size_t>& counts) {
  std::vector<FiltrationStep> steps;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    steps.push_back({0.1 * static_cast<double>(i + 1), counts[i]});
  }
  return steps;
}

FiltrationStep chooseByRatio(const std::vector<FiltrationStep>& steps, double ratio) {
  return *choosePlateau(steps, ratio * computeLongestLifetime(steps));
}

TEST(Plateau, IsTheLongRunWithMostComponents) {
  const auto steps = makeCounts({1, 1, 1, 1, 2, 2, 3, 2});
  EXPECT_EQ(toPairs({chooseByRatio(steps, 0.1)}), (Pairs{{0.1 * 5, 2}}));
  EXPECT_EQ(toPairs({chooseByRatio(steps, 0.4)}), (Pairs{{0.1 * 1, 1}}));
  EXPECT_EQ(toPairs({chooseByRatio(steps, 0.0)}), (Pairs{{0.1 * 7, 3}}));
}

TEST(Plateau, IsTheSmallestDilationAmongEqualCounts) {
  EXPECT_EQ(toPairs({chooseByRatio(makeCounts({2, 2, 1, 1, 2, 2}), 0.5)}), (Pairs{{0.1, 2}}));
}

TEST(Plateau, IsTheFirstRunIfOnlyRunsWithoutComponentsAreLong) {
  EXPECT_EQ(toPairs({chooseByRatio(makeCounts({1, 0, 0, 0}), 0.5)}), (Pairs{{0.1, 1}}));
  EXPECT_FALSE(choosePlateau({}, 0.0));
}

TEST(Window, EndsBeforeTheLastEntryBelowTheLargestDilation) {
  const auto steps = makeCounts({5, 4, 3, 2, 1});
  EXPECT_EQ(toPairs(cutToWindow(steps, 0.15, 0.45)), (Pairs{{0.1 * 2, 4}, {0.1 * 3, 3}}));
  EXPECT_EQ(cutToWindow(steps, 0.0, 0.05).size(), 5U) << "nothing below: the whole list";
  EXPECT_TRUE(cutToWindow(steps, 0.6, 0.9).empty());
}

PlaceGraph makeWorkedExample() {
  return makeGraph(6, 1.0, {{0, 1, .9}, {1, 2, .8}, {2, 3, .55}, {3, 4, .85}, {4, 5, .95}});
}

GeometricRoomsConfig makeSmallRooms() {
  GeometricRoomsConfig config;
  config.min_component_size = 2;
  config.min_room_size = 2;
  return config;
}

TEST(GeometricRooms, OfTheWorkedExample) {
  const PlaceGraph graph = makeWorkedExample();
  const auto filtration = computeFiltration(graph, 2, -1.0);
  EXPECT_EQ(toPairs(filtration), (Pairs{{.55, 1}, {.8, 2}, {.85, 2}, {.9, 2}, {.95, 1}}));
  const auto window = cutToWindow(filtration, .5, 1.2);
  EXPECT_EQ(window.size(), 4U);
  EXPECT_EQ(toPairs({chooseByRatio(window, .25)}), (Pairs{{.8, 2}}));
  EXPECT_EQ(computeGeometricRooms(graph, makeSmallRooms()),
            (std::vector<Ids>{{{1}, {2}, {3}}, {{4}, {5}, {6}}}));
}

TEST(GeometricRooms, LeaveOutPlacesThatNothingJoinsAndRoomsThatAreTooSmall) {
  PlaceGraph graph = makeWorkedExample();
  graph.places.push_back({{7}, {9, 9, 0}, 1.0, {}, 0});
  GeometricRoomsConfig config = makeSmallRooms();
  EXPECT_EQ(computeGeometricRooms(graph, config).size(), 2U);
  config.min_room_size = 4;
  EXPECT_TRUE(computeGeometricRooms(graph, config).empty());
  EXPECT_TRUE(computeGeometricRooms({}, config).empty());
}

TEST(GeometricRooms, ByAnAbsoluteLifetimeMayBeOthers) {
  GeometricRoomsConfig config = makeSmallRooms();
  config.dilation_choice = DilationChoice::kPlateauThreshold;
  config.min_lifetime_m = 0.05;
  EXPECT_EQ(computeGeometricRooms(makeWorkedExample(), config).size(), 2U);
  config.min_lifetime_m = 0.2;  // no run is that long: the first, at 0.55
  EXPECT_EQ(computeGeometricRooms(makeWorkedExample(), config),
            (std::vector<Ids>{{{1}, {2}, {3}}, {{4}, {5}, {6}}}));
}

/// Two square rooms of side x side places and a door in the middle of the wall between them.
PlaceGraph makeTwoRooms(std::uint64_t side, double door_m) {
  PlaceGraph graph;
  const auto idAt = [&](std::uint64_t x, std::uint64_t y) { return PlaceId{1 + y * 2 * side + x}; };
  for (std::uint64_t y = 0; y < side; ++y) {
    for (std::uint64_t x = 0; x < 2 * side; ++x) {
      graph.places.push_back(
          {idAt(x, y), {static_cast<double>(x), static_cast<double>(y), 0}, 1.0, {}, 0});
    }
  }
  for (std::uint64_t y = 0; y < side; ++y) {
    for (std::uint64_t x = 0; x < 2 * side; ++x) {
      const bool is_wall = x + 1 == side;
      if (x + 1 < 2 * side && !is_wall) graph.edges.push_back({idAt(x, y), idAt(x + 1, y), 0.9});
      if (is_wall && y == side / 2) graph.edges.push_back({idAt(x, y), idAt(x + 1, y), door_m});
      if (y + 1 < side) graph.edges.push_back({idAt(x, y), idAt(x, y + 1), 1.0});
    }
  }
  return graph;
}

TEST(GeometricRooms, EndAtADoor) {
  const auto rooms = computeGeometricRooms(makeTwoRooms(4, 0.6), GeometricRoomsConfig{});
  ASSERT_EQ(rooms.size(), 2U);
  EXPECT_EQ(rooms[0].size(), 16U);
  EXPECT_EQ(rooms[1].size(), 16U);
  EXPECT_EQ(rooms[0].front(), PlaceId{1});
  EXPECT_EQ(rooms[1].front(), PlaceId{5});
}

class RandomRooms : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, RandomRooms, ::testing::Range(1U, 9U));

TEST_P(RandomRooms, AreDisjointAndDoNotDependOnTheOrderOfEdges) {
  std::mt19937 random(GetParam());
  PlaceGraph graph = makeTwoRooms(5, 0.5);
  std::uniform_int_distribution<int> draw(3, 12);  // few values, so that many are equal
  for (Place& place : graph.places) place.clearance_m = 0.1 * draw(random);
  for (PlaceEdge& edge : graph.edges) edge.clearance_m = 0.1 * draw(random);
  GeometricRoomsConfig config = makeSmallRooms();
  const auto rooms = computeGeometricRooms(graph, config);
  std::shuffle(graph.edges.begin(), graph.edges.end(), random);
  EXPECT_EQ(computeGeometricRooms(graph, config), rooms);
  Ids all;
  for (const auto& room : rooms) all.insert(all.end(), room.begin(), room.end());
  std::sort(all.begin(), all.end());
  EXPECT_EQ(std::adjacent_find(all.begin(), all.end()), all.end());
}

}  // namespace
}  // namespace tsg::scene_graph
