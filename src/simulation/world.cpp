// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/world.h"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>

#include "floor_plan.h"
#include "furnisher.h"
#include "stairs.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/simulation/walk.h"

namespace tsg::simulation {
namespace {

constexpr int kAttempts = 40;
constexpr double kWalkClearance_m = 0.33;

PlanStyle makeCubicleStyle() {
  PlanStyle style;
  style.types.assign(4, {RoomKind::kCubicle, "cubicle", 3.4});
  style.min_depth_m = 3.2;
  style.max_depth_m = 3.5;
  style.partition_height_m = 1.5;
  return style;
}

PlanStyle makeOfficeStyle() {
  PlanStyle style;
  style.types = {
      {RoomKind::kDeskBay, "desk area", 5.2},        {RoomKind::kDeskBay, "desk area", 5.2},
      {RoomKind::kMeetingArea, "meeting area", 4.8}, {RoomKind::kLounge, "lounge", 4.6},
      {RoomKind::kKitchen, "kitchenette", 4.4},      {RoomKind::kPrintArea, "print area", 3.8}};
  style.is_open = true;
  return style;
}

PlanStyle makeStoreyStyle(int floor) {
  static const std::array<std::vector<RoomType>, 3> kFloors = {
      {{{RoomKind::kLounge, "lounge", 5.0},
        {RoomKind::kKitchen, "canteen", 4.6},
        {RoomKind::kMeetingArea, "meeting room", 4.6},
        {RoomKind::kPrintArea, "print room", 3.8},
        {RoomKind::kBathroom, "bathroom", 3.2},
        {RoomKind::kStorageRoom, "storage room", 3.2}},
       {{RoomKind::kDeskBay, "office", 5.0},
        {RoomKind::kDeskBay, "office", 5.0},
        {RoomKind::kMeetingArea, "meeting room", 4.6},
        {RoomKind::kCubicle, "laboratory", 4.0},
        {RoomKind::kCubicle, "laboratory", 4.0},
        {RoomKind::kPrintArea, "print room", 3.8}},
       {{RoomKind::kLivingRoom, "living room", 5.2},
        {RoomKind::kKitchen, "kitchen", 4.4},
        {RoomKind::kBedroom, "bedroom", 4.4},
        {RoomKind::kOffice, "study", 4.0},
        {RoomKind::kChildrensRoom, "children's room", 3.9},
        {RoomKind::kBathroom, "bathroom", 3.2}}}};
  PlanStyle style;
  style.types = kFloors[static_cast<std::size_t>(floor)];
  style.length_m = 13.5;
  style.opens_east = true;
  return style;
}

bool isWalkable(const Apartment& storey) {
  const auto viewpoints = findViewpoints(storey, FloorMap(storey), kWalkClearance_m);
  return std::none_of(viewpoints.begin(), viewpoints.end(),
                      [](const auto& points) { return points.empty(); });
}

/// `name` keeps the numbers of one storey apart from those of another.
Apartment buildStorey(const ApartmentConfig& config, const PlanStyle& style,
                      const std::string& name) {
  const std::uint64_t own = combineSeeds(static_cast<std::uint64_t>(config.seed), hashText(name));
  for (std::uint64_t attempt = 0; attempt < kAttempts; ++attempt) {
    Random plan(combineSeeds(own, hashText("floor plan")));
    Apartment storey = buildPlan(config, style, plan);
    Random furniture(combineSeeds(own, hashText("furniture") + attempt));
    furnishWorkRooms(storey, furniture);
    if (isWalkable(storey)) return storey;
  }
  throw std::runtime_error(name + " of seed " + std::to_string(config.seed) + ": in " +
                           std::to_string(kAttempts) +
                           " attempts furniture blocked a room, expected a way into each");
}

void addStaircaseRoom(Apartment& storey) {
  const Room room = makeStaircaseRoom(storey);
  storey.rooms.push_back(room);
  for (Doorway& door : storey.doorways) {
    if (door.room_b == 0) door.room_b = room.id;
  }
}

void lift(Apartment& storey, int floor) {
  const Eigen::Vector3d up(0.0, 0.0, floor * kStorey_m);
  for (Room& room : storey.rooms) {
    room.floor = floor;
    room.floor_z_m = up.z();
  }
  for (Solid& solid : storey.solids) solid.T_world_solid.pretranslate(up);
  for (Instance& instance : storey.instances) {
    instance.T_world_instance.pretranslate(up);
    instance.box.translate(up);
  }
  for (Group& group : storey.groups) group.T_world_group.pretranslate(up);
}

/// Ids of the storey follow those of the building.
void append(Apartment& building, Apartment storey) {
  const auto rooms = static_cast<int>(building.rooms.size());
  const auto instances = static_cast<std::uint16_t>(building.instances.size());
  const auto parts = static_cast<std::uint16_t>(building.parts.size());
  const auto shift = [](std::uint16_t& id, std::uint16_t by) {
    if (id != 0) id = static_cast<std::uint16_t>(id + by);
  };
  for (Room& room : storey.rooms) room.id += rooms;
  for (Doorway& door : storey.doorways) {
    door.room_a += rooms;
    door.room_b += rooms;
  }
  for (Instance& instance : storey.instances) {
    shift(instance.id, instances);
    instance.room += rooms;
  }
  for (Part& part : storey.parts) shift(part.instance, instances);
  for (Solid& solid : storey.solids) {
    shift(solid.instance, instances);
    shift(solid.part, parts);
  }
  for (Group& group : storey.groups) {
    for (std::uint16_t& id : group.instances) shift(id, instances);
  }
  const auto join = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  join(building.rooms, storey.rooms);
  join(building.doorways, storey.doorways);
  join(building.instances, storey.instances);
  join(building.parts, storey.parts);
  join(building.solids, storey.solids);
  join(building.groups, storey.groups);
}

Apartment buildBuilding(const ApartmentConfig& config) {
  constexpr int kFloors = 3;
  Apartment building;
  building.config = config;
  for (int floor = 0; floor < kFloors; ++floor) {
    Apartment storey =
        buildStorey(config, makeStoreyStyle(floor), "storey " + std::to_string(floor));
    addStaircaseRoom(storey);
    lift(storey, floor);
    append(building, std::move(storey));
  }
  addStairs(building, kFloors);
  return building;
}

}  // namespace

WorldKind parseWorldKind(const std::string& name) {
  static const std::map<std::string, WorldKind> kNames = {{"apartment", WorldKind::kApartment},
                                                          {"cubicle", WorldKind::kCubicle},
                                                          {"office", WorldKind::kOffice},
                                                          {"building", WorldKind::kBuilding}};
  const auto found = kNames.find(name);
  if (found != kNames.end()) return found->second;
  throw std::invalid_argument("world '" + name +
                              "', expected apartment, cubicle, office or building");
}

Apartment buildWorld(WorldKind kind, const ApartmentConfig& config) {
  config::validate(config, "world");
  switch (kind) {
    case WorldKind::kCubicle:
      return buildStorey(config, makeCubicleStyle(), "cubicle");
    case WorldKind::kOffice:
      return buildStorey(config, makeOfficeStyle(), "office");
    case WorldKind::kBuilding:
      return buildBuilding(config);
    default:
      return buildApartment(config);
  }
}

}  // namespace tsg::simulation
