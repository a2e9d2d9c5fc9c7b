// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/map_regions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <stdexcept>

#include "support.h"

namespace tsg::evaluation {
namespace {

constexpr const char* kGraph = R"({"nodes": [
  {"id": 10, "layer": 3, "attributes": {"position": [0.5, 0.5, 0.6], "distance": 0.4}},
  {"id": 7, "layer": 3, "attributes": {"position": [1.5, 0.5, 0.6], "distance": 0.4}},
  {"id": 8, "layer": 3, "attributes": {"position": [0.5, 0.5, 3.6], "distance": 0.8}},
  {"id": 90, "layer": 4, "attributes": {}}, {"id": 91, "layer": 4, "attributes": {}}],
 "edges": [{"source": 90, "target": 10}, {"source": 91, "target": 7}, {"source": 90, "target": 91},
           {"source": 91, "target": 8}, {"source": 7, "target": 10}]})";

class MapFolder : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    const auto path = folder_.path() / name;
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
  }

  template <typename Function>
  std::string failOf(const Function& load) const {
    try {
      load();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  test::TemporaryFolder folder_;
};

TEST_F(MapFolder, RegionsHaveThePlacesThatEdgesFromTheirRoomLeadTo) {
  const MapRegions map = loadMapRegions(write("graph.json", kGraph));
  ASSERT_EQ(map.places.places.size(), 3U);
  EXPECT_EQ(map.places.places[0].id, PlaceId{7});  // ascending
  EXPECT_EQ(map.places.places[2].position_m, Eigen::Vector3d(0.5, 0.5, 0.6));
  EXPECT_DOUBLE_EQ(map.places.places[1].clearance_m, 0.8);
  ASSERT_EQ(map.regions.size(), 2U);
  EXPECT_EQ(map.regions[0], (std::vector<PlaceId>{{10}}));
  EXPECT_EQ(map.regions[1], (std::vector<PlaceId>{{7}, {8}}));
}

TEST_F(MapFolder, FreeCellsOfAGroundPlanAreSamplesWithTheLowestRowLast) {
  write("floor_0.yaml",
        "# Floor at z = 3.1 m.\nimage: f.pgm\nresolution: 0.5\norigin: [-1, 2, 0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  write("f.pgm", std::string("P5\n2 2\n255\n") + '\xfe' + '\x00' + '\xcd' + '\xfe');
  const auto floors = loadFloors(folder_.path().string());
  ASSERT_EQ(floors.size(), 1U);
  EXPECT_DOUBLE_EQ(floors[0].floor_m, 3.1);
  ASSERT_EQ(floors[0].samples_m.size(), 2U);  // 0xcd is unknown
  EXPECT_LT((floors[0].samples_m[0] - Eigen::Vector3d(-0.75, 2.75, 3.6)).norm(), 1e-9);
  EXPECT_LT((floors[0].samples_m[1] - Eigen::Vector3d(-0.25, 2.25, 3.6)).norm(), 1e-9);
  EXPECT_TRUE(loadFloors((folder_.path() / "none").string()).empty());
}

TEST_F(MapFolder, RoomsOfWorldsHousesAndHydraAreRead) {
  const auto world =
      loadRoomTruth(write("rooms.json", R"({"rooms": [{"name": "hall", "rectangle_m": [0, 1, 4, 3],
                              "floor_z_m": 3.0, "height_m": 2.6}]})"));
  ASSERT_EQ(world.size(), 1U);
  EXPECT_EQ(world[0].name, "hall");
  EXPECT_TRUE(world[0].boxes[0].contains({3.9, 1.1, 3.5}, 0.0));
  EXPECT_FALSE(world[0].boxes[0].contains({3.9, 1.1, 0.5}, 0.0));  // the floor below
  const auto house = loadRoomTruth(
      write("house.json", R"([{"name": "a", "rects": [[0, 0, 1, 1], [5, 0, 6, 1]]}])"));
  ASSERT_EQ(house[0].boxes.size(), 2U);
  EXPECT_TRUE(house[0].boxes[1].contains({5.5, 0.5, 7.0}, 0.0));
  const double half = 0.125 * std::acos(-1.0);  // of 45 degrees
  const auto hydra = loadRoomTruth(
      write("rooms.yaml", "3:\n- {center: [0, 0, 1], extents: [2, 2, 2], rotation: {w: " +
                              std::to_string(std::cos(half)) +
                              ", x: 0, y: 0, z: " + std::to_string(std::sin(half)) + "}}\n"));
  EXPECT_TRUE(hydra[0].boxes[0].contains({1.3, 0.0, 1.0}, 0.0));
  EXPECT_FALSE(hydra[0].boxes[0].contains({0.9, 0.9, 1.0}, 0.0));
}

/// A storey of 2 m x 1 m in cells of 0.1 m.
FloorSamples makeFloor(double floor_m) {
  FloorSamples floor;
  floor.floor_m = floor_m;
  for (int i = 0; i < 200; ++i) {
    floor.samples_m.emplace_back(0.05 + 0.1 * (i % 20), 0.05 + 0.1 * (i / 20), floor_m + 0.5);
  }
  return floor;
}

OrientedBox makeRoom(double x0, double x1, double z0) {
  return toOrientedBox(makeAabb(Eigen::Vector3d(x0, 0.0, z0), Eigen::Vector3d(x1, 1.0, z0 + 2.6)));
}

TEST_F(MapFolder, PlacesCountOnTheirOwnStoreyOnly) {
  const MapRegions map = loadMapRegions(write("graph.json", kGraph));
  const std::vector<TrueRoom> rooms{{"west", {makeRoom(0, 1, 0)}}, {"east", {makeRoom(1, 2, 0)}}};
  const RegionScores below = scoreRegions(map, {makeFloor(0.0)}, rooms);
  EXPECT_EQ(below.room_recalls.size(), 2U);
  EXPECT_DOUBLE_EQ(below.precision, 1.0);  // each place's disc lies in its own room
  EXPECT_NEAR(below.recall, 0.52, 0.04);   // a disc of 0.4 m in a square of 1 m
  // Upstairs one region has a disc of 0.8 m, the other none.
  const std::vector<TrueRoom> above{{"up", {makeRoom(0, 2, 3)}}};
  EXPECT_NEAR(scoreRegions(map, {makeFloor(3.0)}, above).recall, 0.6, 0.1);
  EXPECT_DOUBLE_EQ(scoreRegions(map, {makeFloor(3.0)}, above).precision, 0.5);
}

TEST_F(MapFolder, RoomsThatWereNotSeenDoNotCount) {
  const MapRegions map = loadMapRegions(write("graph.json", kGraph));
  const std::vector<TrueRoom> rooms{{"west", {makeRoom(0, 1, 0)}},
                                    {"closed", {makeRoom(7, 9, 0)}},
                                    {"gap", {makeRoom(1.5, 1.9, 0)}}};
  EXPECT_EQ(scoreRegions(map, {makeFloor(0.0)}, rooms).room_recalls.size(), 1U);
}

TEST_F(MapFolder, ErrorsNameTheFile) {
  const std::string text = write("bad.json", R"({"nodes": [{"id": 1}], "edges": []})");
  EXPECT_NE(failOf([&] { loadMapRegions(text); }).find("bad.json"), std::string::npos);
  EXPECT_NE(failOf([&] { loadMapRegions("/none.json"); }).find("/none.json"), std::string::npos);
  EXPECT_NE(failOf([&] { loadRoomTruth(text); }).find("bad.json"), std::string::npos);
  const std::string hydra = write("bad.yaml", "1: [{center: [1, 2]}]\n");
  EXPECT_NE(failOf([&] { loadRoomTruth(hydra); }).find("bad.yaml"), std::string::npos);
  write("floor_0.yaml", "image: f.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nfree_thresh: 0.2\n");
  write("f.pgm", "P5\n2 2\n255\nx");
  const std::string folder = folder_.path().string();
  EXPECT_NE(failOf([&] { loadFloors(folder); }).find("ends early"), std::string::npos);
  write("f.pgm", "P5\n1 1\n255\nx");
  write("floor_0.yaml", "image: f.pgm\n");
  EXPECT_NE(failOf([&] { loadFloors(folder); }).find("floor_0.yaml"), std::string::npos);
}

}  // namespace
}  // namespace tsg::evaluation
