// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/simulation/apartment.h"
#include "task_scene_graph/simulation/random.h"

namespace tsg::simulation {

constexpr double kCorridorWidth_m = 1.9;
constexpr double kOuterWall_m = 0.25;
constexpr double kSlab_m = 0.2;
constexpr double kStorey_m = 3.0;  ///< from floor to floor: a room's height and two slabs

struct RoomType {
  RoomKind kind;
  const char* phrase;
  double width_m;
};

/// Rooms on both sides of a corridor.
struct PlanStyle {
  std::vector<RoomType> types;  ///< the widest first
  double min_depth_m = 3.8;
  double max_depth_m = 4.4;
  double length_m = 0.0;              ///< of the corridor; 0: as the rooms' widths ask for
  double partition_height_m = 100.0;  ///< of inner walls; up to the ceiling if it is higher
  bool is_open = false;               ///< no inner walls: bays beside an aisle
  bool opens_east = false;            ///< the corridor's east end is open, for a staircase
};

/// Walls, floors and ceilings at z = 0. Deterministic in `random`.
Apartment buildPlan(const ApartmentConfig& config, const PlanStyle& style, Random& random);

/// Adds a box of structure, none if it has no volume.
void addBox(Apartment& apartment, const Aabb& box, const Material& material);

}  // namespace tsg::simulation
