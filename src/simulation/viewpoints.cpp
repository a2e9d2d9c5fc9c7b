// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>

#include "task_scene_graph/simulation/walk.h"

namespace tsg::simulation {
namespace {

constexpr double kInside_m = 1.2;   ///< from every doorway
constexpr double kFromEnd_m = 0.8;  ///< of the corridor

double distanceToDoors(const Apartment& apartment, const Room& room, const Eigen::Vector2d& p_m) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Doorway& door : apartment.doorways) {
    if (door.room_a == room.id || door.room_b == room.id) {
      nearest_m = std::min(nearest_m, (door.center_m - p_m).norm());
    }
  }
  return nearest_m;
}

template <typename Score>
bool pickBest(const std::vector<Eigen::Vector2d>& points, const Score& score,
              Eigen::Vector2d& best) {
  double best_score = -std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& p : points) {
    const double value = score(p);
    if (value > best_score) {
      best_score = value;
      best = p;
    }
  }
  return !points.empty();
}

/// Near the middle with room around: from there the camera sees furniture, not a wall.
std::vector<Eigen::Vector2d> pickInRoom(const FloorMap& map, const Room& room,
                                        const std::vector<Eigen::Vector2d>& candidates) {
  const Eigen::Vector2d middle = room.interior_m.center();
  Eigen::Vector2d best = middle;
  const auto is_central = [&](const Eigen::Vector2d& p) {
    return std::min(map.computeClearance(p), 0.7) - 0.3 * (p - middle).norm();
  };
  if (!pickBest(candidates, is_central, best)) return {};
  return {best};
}

/// Both ends of the corridor, the western one first.
std::vector<Eigen::Vector2d> pickInCorridor(const Room& corridor,
                                            const std::vector<Eigen::Vector2d>& reachable) {
  std::vector<Eigen::Vector2d> inside;
  for (const Eigen::Vector2d& p : reachable) {
    const bool near_end = std::min(p.x() - corridor.interior_m.min().x(),
                                   corridor.interior_m.max().x() - p.x()) < kFromEnd_m;
    if (corridor.interior_m.contains(p) && !near_end) inside.push_back(p);
  }
  if (inside.empty()) return {};
  std::vector<Eigen::Vector2d> ends(2, Eigen::Vector2d::Zero());
  for (std::size_t i = 0; i < 2; ++i) {
    const double sign = i == 0 ? -1.0 : 1.0;
    pickBest(
        inside, [&](const Eigen::Vector2d& p) { return sign * p.x() - std::abs(p.y()); }, ends[i]);
  }
  return ends;
}

}  // namespace

std::vector<std::vector<Eigen::Vector2d>> findViewpoints(const Apartment& apartment,
                                                         const FloorMap& map, double clearance_m) {
  const Room& corridor = apartment.rooms.front();
  const auto reachable = map.findReachable(corridor.interior_m.center(), clearance_m);
  std::vector<std::vector<Eigen::Vector2d>> viewpoints = {pickInCorridor(corridor, reachable)};
  for (std::size_t i = 1; i < apartment.rooms.size(); ++i) {
    const Room& room = apartment.rooms[i];
    std::vector<Eigen::Vector2d> candidates;
    for (const Eigen::Vector2d& p : reachable) {
      if (room.interior_m.contains(p) && distanceToDoors(apartment, room, p) > kInside_m) {
        candidates.push_back(p);
      }
    }
    viewpoints.push_back(pickInRoom(map, room, candidates));
  }
  return viewpoints;
}

}  // namespace tsg::simulation
