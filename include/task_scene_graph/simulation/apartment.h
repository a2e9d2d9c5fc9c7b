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
  kStorageRoom
};

/// Walls of a room by the direction in which they lie.
enum class Side { kNorth, kWest, kSouth, kEast };  // quarter turns that bring +y to the wall

struct Room {
  int id = 0;  ///< from 1
  RoomKind kind = RoomKind::kCorridor;
  std::string phrase;
  Rect interior_m;  ///< between the walls
  double height_m = 2.6;
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

/// A furnished apartment of closed-form solids. World frame: z up, floor at z = 0, metres.
struct Apartment {
  ApartmentConfig config;
  double wall_m = 0.12;
  std::vector<Room> rooms;  ///< id = index + 1; the corridor is the first
  std::vector<Doorway> doorways;
  std::vector<Instance> instances;  ///< id = index + 1
  std::vector<Part> parts;          ///< id = index + 1
  std::vector<Solid> solids;

  /// Id of the room whose interior holds the point; 0 inside walls, doorways and outside.
  int findRoom(const Eigen::Vector2d& p_m) const;
};

/// Builds and furnishes the apartment: rooms on both sides of a corridor, doorways of 0.9 m,
/// windows, furniture along walls and in the middle, small things on it. Different instances share
/// no volume. Every room can be walked into. Deterministic in the configuration.
/// @throws config::ConfigError if a field is out of range.
Apartment buildApartment(const ApartmentConfig& config);

/// Walls, floors and ceilings only: rooms and doorways without furniture (no instance).
Apartment buildFloorPlan(const ApartmentConfig& config);

}  // namespace tsg::simulation
