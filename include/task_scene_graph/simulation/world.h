// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "task_scene_graph/simulation/apartment.h"

namespace tsg::simulation {

/// Worlds whose truth is known. All but the apartment have groups of things that touch: stacks of
/// books, piles of packets, rows of binders, ...
enum class WorldKind {
  kApartment,
  kCubicle,  ///< four cubicles between low partitions, clutter on their tables
  kOffice,   ///< open plan: bays beside an aisle, without inner walls
  kBuilding  ///< three floors of rooms, joined by stairs
};

/// "apartment", "cubicle", "office" or "building".
/// @throws std::invalid_argument naming the word and what was expected.
WorldKind parseWorldKind(const std::string& name);

/// Every room can be walked into; different instances share no volume. Deterministic in the kind
/// and `config.seed`; `config.num_rooms` is for apartments.
/// @throws config::ConfigError if a field is out of range; std::runtime_error if furniture blocks a
/// room in every attempt.
Apartment buildWorld(WorldKind kind, const ApartmentConfig& config);

}  // namespace tsg::simulation
