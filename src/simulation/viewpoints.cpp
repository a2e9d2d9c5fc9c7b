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

/// The first near the middle with room around: from there the camera sees furniture, not a wall.
/// The others with as much room, away from those before.
std::vector<Eigen::Vector2d> pickInRoom(const FloorMap& map, const Room& room,
                                        const std::vector<Eigen::Vector2d>& candidates, int count) {
  const Eigen::Vector2d middle = room.interior_m.center();
  const auto is_central = [&](const Eigen::Vector2d& p) {
    return std::min(map.computeClearance(p), 0.7) - 0.3 * (p - middle).norm();
  };
  std::vector<Eigen::Vector2d> picked;
  const auto is_elsewhere = [&](const Eigen::Vector2d& p) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& other : picked) {
      nearest_m = std::min(nearest_m, (p - other).norm());
    }
    return std::min(map.computeClearance(p), 0.7) + 0.5 * nearest_m;
  };
  Eigen::Vector2d best = middle;
  if (pickBest(candidates, is_central, best)) picked.push_back(best);
  while (!picked.empty() && static_cast<int>(picked.size()) < count) {
    pickBest(candidates, is_elsewhere, best);
    picked.push_back(best);
  }
  return picked;
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
                                                         const FloorMap& map, double clearance_m,
                                                         int floor, int stops_per_room) {
  std::vector<std::vector<Eigen::Vector2d>> viewpoints(apartment.rooms.size());
  std::vector<Eigen::Vector2d> reachable;
  for (std::size_t i = 0; i < apartment.rooms.size(); ++i) {
    const Room& room = apartment.rooms[i];
    if (room.floor != floor) continue;
    if (room.kind == RoomKind::kCorridor) {
      reachable = map.findReachable(room.interior_m.center(), clearance_m);
      viewpoints[i] = pickInCorridor(room, reachable);
      continue;
    }
    std::vector<Eigen::Vector2d> candidates;
    for (const Eigen::Vector2d& p : reachable) {
      if (room.interior_m.contains(p) && distanceToDoors(apartment, room, p) > kInside_m) {
        candidates.push_back(p);
      }
    }
    viewpoints[i] = pickInRoom(map, room, candidates, stops_per_room);
  }
  return viewpoints;
}

}  // namespace tsg::simulation
