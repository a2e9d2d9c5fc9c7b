// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "task_scene_graph/simulation/model.h"

namespace tsg::simulation {

struct ApartmentConfig {
  int seed = 1;
  int num_rooms = 6;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("seed", self.seed, {0.0, 2147483647.0}, "", "everything follows from it");
    v.field("num_rooms", self.num_rooms, {3.0, 8.0}, "rooms", "the corridor among them");
  }
};

enum class RoomKind {
  kCorridor,
  kKitchen,
  kLivingRoom,
  kBedroom,
  kBathroom,
  kOffice,
  kChildrensRoom,
  kStorageRoom,
  kCubicle,  ///< these and the next only in worlds of work, see world.h
  kDeskBay,
  kMeetingArea,
  kLounge,
  kPrintArea,
  kStaircase
};

/// Walls of a room by the direction in which they lie.
enum class Side { kNorth, kWest, kSouth, kEast };  // quarter turns that bring +y to the wall

struct Room {
  int id = 0;  ///< from 1
  RoomKind kind = RoomKind::kCorridor;
  std::string phrase;
  Rect interior_m;  ///< between the walls
  double height_m = 2.6;
  int floor = 0;                   ///< 0: the lowest
  double floor_z_m = 0.0;          ///< of that floor
  Side outer_side = Side::kNorth;  ///< where its windows are
  Color wall_color{0.9F, 0.9F, 0.88F};
};

/// An opening in a wall, as high as a door.
struct Doorway {
  int room_a = 0;
  int room_b = 0;
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();
  bool leads_along_y = true;  ///< the wall runs along x
  double width_m = 0.9;
  double height_m = 2.05;
};

struct Part {
  std::uint16_t instance = 0;
  std::string name;  ///< of the solids that make it up, such as "seat"
};

struct Instance {
  std::uint16_t id = 0;  ///< from 1; the value in label images
  std::string phrase;
  std::string color_name;
  int room = 0;
  bool seen_in_parts = false;
  Pose T_world_instance = Pose::Identity();
  Aabb local_box;  ///< in the instance's frame
  Aabb box;        ///< world frame, exact
};

/// Instances that touch and belong together, such as a stack of books: one thing or several, as a
/// task sees it.
struct Group {
  std::string phrase;
  std::vector<std::uint16_t> instances;  ///< ascending
  Pose T_world_group = Pose::Identity();
  Aabb local_box;  ///< of all of them, in the group's frame, exact
};

/// A furnished apartment, or another world, of closed-form solids. World frame: z up, lowest floor
/// at z = 0, metres.
struct Apartment {
  ApartmentConfig config;
  double wall_m = 0.12;
  std::vector<Room> rooms;  ///< id = index + 1; the corridor is the first
  std::vector<Doorway> doorways;
  std::vector<Instance> instances;  ///< id = index + 1
  std::vector<Part> parts;          ///< id = index + 1
  std::vector<Solid> solids;
  std::vector<Group> groups;  ///< none in an apartment
  /// Ways up the stairs, on the ground: entry k leads from floor k to floor k + 1.
  std::vector<std::vector<Eigen::Vector3d>> stairs;

  int countFloors() const { return static_cast<int>(stairs.size()) + 1; }
  /// Id of the room of a floor whose interior holds the point; 0 inside walls, doorways and
  /// outside.
  int findRoom(const Eigen::Vector2d& p_m, int floor = 0) const;
  /// Likewise, on the floor that the height belongs to.
  int findRoom(const Eigen::Vector3d& p_m) const;
};

/// Builds and furnishes the apartment: rooms on both sides of a corridor, doorways of 0.9 m,
/// windows, furniture along walls and in the middle, small things on it. Different instances share
/// no volume. Every room can be walked into. Deterministic in the configuration.
/// @throws config::ConfigError if a field is out of range.
Apartment buildApartment(const ApartmentConfig& config);

/// Walls, floors and ceilings only: rooms and doorways without furniture (no instance).
Apartment buildFloorPlan(const ApartmentConfig& config);

}  // namespace tsg::simulation
