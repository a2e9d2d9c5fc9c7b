// SPDX-License-Identifier: BSD-3-Clause
#include "taut_path.h"

#include <algorithm>
#include <cmath>

namespace tsg::planning {
namespace {

/// Corners are cut until a round saves less than this share of the length.
constexpr double kLeastGain = 1e-3;
constexpr int kMaxRounds = 12;

/// The last corner that can be walked to straight from corner `from`, looked for in strides that
/// double while they succeed and halve when they fail.
std::size_t findFarthest(const NavigationGrid& grid, const Waypoints& path, std::size_t from,
                         double radius_m) {
  std::size_t reached = from + 1;
  std::size_t stride = 1;
  while (reached + stride < path.size() &&
         canWalk(grid, path[from], path[reached + stride], radius_m)) {
    reached += stride;
    stride *= 2;
  }
  for (; stride > 0; stride /= 2) {
    if (reached + stride >= path.size()) continue;
    if (canWalk(grid, path[from], path[reached + stride], radius_m)) reached += stride;
  }
  return reached;
}

Waypoints leaveOutCorners(const NavigationGrid& grid, const Waypoints& path, double radius_m) {
  Waypoints kept{path.front()};
  for (std::size_t at = 0; at + 1 < path.size();) {
    at = findFarthest(grid, path, at, radius_m);
    kept.push_back(path[at]);
  }
  return kept;
}

/// The point `away_m` from a corner towards another.
Waypoint moveTowards(const NavigationGrid& grid, const Waypoint& corner, const Waypoint& to,
                     double away_m, double radius_m) {
  const Eigen::Vector2d along_m = to.position_m - corner.position_m;
  const Eigen::Vector2d p_m = corner.position_m + along_m * (away_m / along_m.norm());
  return {grid.walk(corner.node, corner.position_m, p_m, radius_m), p_m};
}

/// Puts two corners, as far apart as can be, in the place of one; or leaves it.
void appendCut(const NavigationGrid& grid, const Waypoint& before, const Waypoint& corner,
               const Waypoint& after, double radius_m, Waypoints& path) {
  const double before_m = (before.position_m - corner.position_m).norm();
  const double after_m = (after.position_m - corner.position_m).norm();
  for (double away_m = 0.95 * std::min(before_m, after_m); away_m > 0.5 * grid.cellSize();
       away_m /= 2.0) {
    const Waypoint a = moveTowards(grid, corner, before, away_m, radius_m);
    const Waypoint b = moveTowards(grid, corner, after, away_m, radius_m);
    if (a.node == NavigationGrid::kNone || b.node == NavigationGrid::kNone) continue;
    if (!canWalk(grid, a, b, radius_m)) continue;
    path.push_back(a);
    path.push_back(b);
    return;
  }
  path.push_back(corner);
}

Waypoints cutCorners(const NavigationGrid& grid, const Waypoints& path, double radius_m) {
  Waypoints cut{path.front()};
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const Waypoint before = cut.back();
    appendCut(grid, before, path[i], path[i + 1], radius_m, cut);
  }
  cut.push_back(path.back());
  return cut;
}

double computePlaneLength(const Waypoints& path) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    length_m += (path[i].position_m - path[i - 1].position_m).norm();
  }
  return length_m;
}

}  // namespace

bool canWalk(const NavigationGrid& grid, const Waypoint& from, const Waypoint& to,
             double radius_m) {
  return grid.walk(from.node, from.position_m, to.position_m, radius_m) == to.node;
}

Waypoints toWaypoints(const NavigationGrid& grid, const std::vector<NavigationGrid::Node>& way) {
  Waypoints path;
  for (const NavigationGrid::Node node : way) path.push_back({node, grid.computeCenter(node)});
  return path;
}

Waypoints pullTaut(const NavigationGrid& grid, Waypoints path, double radius_m) {
  if (path.size() < 3) return path;
  path = leaveOutCorners(grid, path, radius_m);
  double length_m = computePlaneLength(path);
  for (int round = 0; round < kMaxRounds && path.size() > 2; ++round) {
    path = leaveOutCorners(grid, cutCorners(grid, path, radius_m), radius_m);
    const double shorter_m = computePlaneLength(path);
    if (shorter_m > (1.0 - kLeastGain) * length_m) break;
    length_m = shorter_m;
  }
  return path;
}

double computeLength(const NavigationGrid& grid, const Waypoints& path) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double rise_m = static_cast<double>(grid.cell(path[i].node).floor_m) -
                          static_cast<double>(grid.cell(path[i - 1].node).floor_m);
    length_m += std::hypot((path[i].position_m - path[i - 1].position_m).norm(), rise_m);
  }
  return length_m;
}

}  // namespace tsg::planning
