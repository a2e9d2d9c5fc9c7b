// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/map_regions.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace tsg::evaluation {
namespace {

using nlohmann::json;

constexpr int kPlaces = 3;  ///< layers of spark_dsg
constexpr int kRooms = 4;
constexpr double kMinRoom_m2 = 1.0;
constexpr double kBelow_m = 0.5;  ///< places of a storey lie from here below its floor
constexpr double kAbove_m = 2.2;  ///< to here above it

Place readPlace(const json& node) {
  const json& attributes = node.at("attributes");
  const json& position = attributes.at("position");
  Place place;
  place.id = {node.at("id").get<std::uint64_t>()};
  place.position_m = {position.at(0).get<double>(), position.at(1).get<double>(),
                      position.at(2).get<double>()};
  place.clearance_m = attributes.at("distance").get<double>();
  return place;
}

MapRegions readRegions(const json& graph) {
  MapRegions map;
  std::map<std::uint64_t, std::size_t> region_of_node;
  for (const json& node : graph.at("nodes")) {
    const int layer = node.at("layer").get<int>();
    const int partition = node.value("partition", 0);
    if (partition != 0) continue;
    if (layer == kPlaces) map.places.places.push_back(readPlace(node));
    if (layer == kRooms) region_of_node.emplace(node.at("id"), region_of_node.size());
  }
  std::sort(map.places.places.begin(), map.places.places.end(),
            [](const Place& a, const Place& b) { return a.id < b.id; });
  map.regions.resize(region_of_node.size());
  for (const json& edge : graph.at("edges")) {
    const auto source = region_of_node.find(edge.at("source").get<std::uint64_t>());
    const auto target = edge.at("target").get<std::uint64_t>();
    if (source == region_of_node.end() || region_of_node.count(target) != 0) continue;
    map.regions[source->second].push_back({target});
  }
  return map;
}

/// Places of one storey; the regions stay as they are.
PlaceGraph pickStorey(const PlaceGraph& places, double floor_m) {
  PlaceGraph storey;
  for (const Place& place : places.places) {
    const double height_m = place.position_m.z() - floor_m;
    if (height_m >= -kBelow_m && height_m < kAbove_m) storey.places.push_back(place);
  }
  return storey;
}

/// Rooms of which enough was seen. `cells`: samples of each room.
std::vector<TrueRoom> pickSeen(const std::vector<TrueRoom>& rooms, const SamplePoints& samples_m,
                               double cell_m2) {
  std::vector<double> seen_m2(rooms.size(), 0.0);
  for (const int room : findRoomOfSamples(samples_m, rooms)) {
    if (room != kOutside) seen_m2[static_cast<std::size_t>(room)] += cell_m2;
  }
  std::vector<TrueRoom> picked;
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    if (seen_m2[i] >= kMinRoom_m2) picked.push_back(rooms[i]);
  }
  return picked;
}

}  // namespace

MapRegions loadMapRegions(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("scene graph '" + path + "' cannot be read");
  try {
    return readRegions(json::parse(file));
  } catch (const json::exception& error) {
    throw std::runtime_error("scene graph '" + path +
                             "' has places or rooms that cannot be read: " + error.what());
  }
}

RegionScores scoreRegions(const MapRegions& map, const std::vector<FloorSamples>& floors,
                          const std::vector<TrueRoom>& rooms) {
  SamplePoints all_m;
  std::vector<SampleSet> regions(map.regions.size());
  double cell_m2 = 0.01;
  for (const FloorSamples& floor : floors) {
    cell_m2 = floor.cell_m * floor.cell_m;
    const auto sets = collectRegionSamples(floor.samples_m, pickStorey(map.places, floor.floor_m),
                                           map.regions, PlaceShape::kColumn);
    for (std::size_t i = 0; i < sets.size(); ++i) {
      for (const std::size_t sample : sets[i]) regions[i].push_back(all_m.size() + sample);
    }
    all_m.insert(all_m.end(), floor.samples_m.begin(), floor.samples_m.end());
  }
  const std::vector<TrueRoom> seen = pickSeen(rooms, all_m, cell_m2);
  return computeRegionScores(
      computeOverlaps(findRoomOfSamples(all_m, seen), seen.size(), regions, true));
}

}  // namespace tsg::evaluation
