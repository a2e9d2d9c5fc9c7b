// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/apartment.h"

#include <algorithm>
#include <stdexcept>

#include "furnisher.h"
#include "task_scene_graph/simulation/walk.h"

namespace tsg::simulation {
namespace {

constexpr int kAttempts = 20;
constexpr double kWalkClearance_m = 0.33;

bool isWalkable(const Apartment& apartment) {
  const auto viewpoints = findViewpoints(apartment, FloorMap(apartment), kWalkClearance_m);
  return std::none_of(viewpoints.begin(), viewpoints.end(),
                      [](const auto& points) { return points.empty(); });
}

}  // namespace

Apartment buildApartment(const ApartmentConfig& config) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Apartment apartment = buildFloorPlan(config);
    Random random(combineSeeds(static_cast<std::uint64_t>(config.seed),
                               hashText("furniture") + static_cast<std::uint64_t>(attempt)));
    furnishRooms(apartment, random);
    if (isWalkable(apartment)) return apartment;
  }
  throw std::runtime_error("apartment of seed " + std::to_string(config.seed) + ": in " +
                           std::to_string(kAttempts) +
                           " attempts furniture blocked a room, expected a way into each");
}

}  // namespace tsg::simulation
