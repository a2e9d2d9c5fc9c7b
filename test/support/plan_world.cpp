// SPDX-License-Identifier: BSD-3-Clause
#include "plan_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <utility>

namespace tsg::test {
namespace {

using places::GroundPlan;
using places::PlanCell;

constexpr double kMaxClearance_m = 5.0;

PlanCell drawCell(const PlanLevel& level, const Eigen::Vector2d& p_m) {
  PlanCell cell;
  const std::optional<double> floor_m = level.findFloor(p_m);
  if (floor_m) cell.floor_m = static_cast<float>(*floor_m);
  if (level.isObstacle(p_m)) {
    cell.state = PlanCell::State::kObstacle;
    if (!floor_m) cell.floor_m = 0.0F;
  } else if (floor_m) {
    cell.state = PlanCell::State::kFree;
    cell.clearance_m = static_cast<float>(level.computeClearance(p_m));
  }
  return cell;
}

GroundPlan::TilePtr drawTile(const PlanLevel& level, const GroundPlan& plan,
                             const GroundPlan::Index& tile) {
  auto drawn = std::make_shared<GroundPlan::Tile>();
  bool is_empty = true;
  for (int y = 0; y < GroundPlan::kTileSide; ++y) {
    for (int x = 0; x < GroundPlan::kTileSide; ++x) {
      const GroundPlan::Index cell{tile.first * GroundPlan::kTileSide + x,
                                   tile.second * GroundPlan::kTileSide + y};
      PlanCell& drawn_cell = (*drawn)[places::computeOffset(cell)];
      drawn_cell = drawCell(level, plan.computeCenter(cell));
      is_empty = is_empty && drawn_cell.state == PlanCell::State::kUnknown;
    }
  }
  return is_empty ? nullptr : drawn;
}

/// Directions of a lattice up to (4, 1) and (3, 2), each once.
std::vector<std::array<int, 2>> findDirections() {
  std::vector<std::array<int, 2>> directions;
  for (int x = -4; x <= 4; ++x) {
    for (int y = -4; y <= 4; ++y) {
      if (std::gcd(x, y) == 1 && std::abs(x) + std::abs(y) <= 5) directions.push_back({x, y});
    }
  }
  return directions;
}

}  // namespace

PlanLevel& PlanLevel::addFloor(const PlanRect& rect, double z_m, double rise) {
  floors_.push_back({rect, z_m, rise});
  return *this;
}

PlanLevel& PlanLevel::addObstacle(const PlanRect& rect) {
  obstacles_.push_back(rect);
  return *this;
}

PlanLevel& PlanLevel::addRoom(const PlanRect& rect) {
  const Eigen::Vector2d wall_m(0.2, 0.2);
  const Eigen::Vector2d min_m = rect.min_m - wall_m;
  const Eigen::Vector2d max_m = rect.max_m + wall_m;
  addFloor(rect);
  addObstacle({min_m, {rect.min_m.x(), max_m.y()}})
      .addObstacle({{rect.max_m.x(), min_m.y()}, max_m});
  return addObstacle({min_m, {max_m.x(), rect.min_m.y()}})
      .addObstacle({{min_m.x(), rect.max_m.y()}, max_m});
}

std::optional<double> PlanLevel::findFloor(const Eigen::Vector2d& p_m) const {
  for (const Floor& floor : floors_) {
    if (!floor.rect.contains(p_m)) continue;
    return floor.z_m + floor.rise * (p_m.x() - floor.rect.min_m.x());
  }
  return std::nullopt;
}

bool PlanLevel::isObstacle(const Eigen::Vector2d& p_m) const {
  return std::any_of(obstacles_.begin(), obstacles_.end(),
                     [&](const PlanRect& rect) { return rect.contains(p_m); });
}

double PlanLevel::computeClearance(const Eigen::Vector2d& p_m) const {
  double clearance_m = kMaxClearance_m;
  for (const PlanRect& rect : obstacles_) {
    clearance_m = std::min(clearance_m, rect.computeDistance(p_m));
  }
  return clearance_m;
}

bool PlanLevel::isFree(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m,
                       double radius_m) const {
  const double steps = std::ceil((b_m - a_m).norm() / 0.02) + 1.0;
  for (double i = 0.0; i <= steps; i += 1.0) {
    const Eigen::Vector2d p_m = a_m + (b_m - a_m) * (i / steps);
    if (!findFloor(p_m) || computeClearance(p_m) < radius_m) return false;
  }
  return true;
}

std::vector<PlanRect> PlanLevel::extents() const {
  std::vector<PlanRect> rects = obstacles_;
  for (const Floor& floor : floors_) rects.push_back(floor.rect);
  return rects;
}

GroundPlan drawPlan(const std::vector<PlanLevel>& levels, double cell_size_m) {
  GroundPlan plan(cell_size_m);
  constexpr double kMargin_m = 0.1;
  std::map<GroundPlan::Index, std::vector<GroundPlan::TilePtr>> tiles;
  for (const PlanLevel& level : levels) {
    for (const PlanRect& rect : level.extents()) {
      const auto low =
          places::computeTile(plan.computeCell(rect.min_m - Eigen::Vector2d::Constant(kMargin_m)));
      const auto high =
          places::computeTile(plan.computeCell(rect.max_m + Eigen::Vector2d::Constant(kMargin_m)));
      for (int x = low.first; x <= high.first; ++x) {
        for (int y = low.second; y <= high.second; ++y) tiles[{x, y}];
      }
    }
  }
  for (auto& [index, floors] : tiles) {
    for (const PlanLevel& level : levels) {
      if (auto tile = drawTile(level, plan, index)) floors.push_back(std::move(tile));
    }
    plan.setTiles(index, floors);
  }
  return plan;
}

PlaceGraph drawPlaces(const std::vector<PlanLevel>& levels, const PlanRect& extent,
                      double lattice_m, double min_clearance_m) {
  PlaceGraph graph;
  std::vector<const PlanLevel*> level_of;
  for (const PlanLevel& level : levels) {
    for (double y = extent.min_m.y() + lattice_m / 2.0; y < extent.max_m.y(); y += lattice_m) {
      for (double x = extent.min_m.x() + lattice_m / 2.0; x < extent.max_m.x(); x += lattice_m) {
        // On the centre of a cell, as places are.
        const Eigen::Vector2d p_m((std::floor(x * 10.0) + 0.5) / 10.0,
                                  (std::floor(y * 10.0) + 0.5) / 10.0);
        const auto floor_m = level.findFloor(p_m);
        if (!floor_m || level.computeClearance(p_m) < min_clearance_m) continue;
        const PlaceId id{graph.places.size() + 1};
        graph.places.push_back(
            {id, {p_m.x(), p_m.y(), *floor_m + 0.5}, level.computeClearance(p_m), {}, 0});
        level_of.push_back(&level);
      }
    }
  }
  const double max_m = 1.5 * lattice_m;
  for (std::size_t a = 0; a < graph.places.size(); ++a) {
    for (std::size_t b = a + 1; b < graph.places.size(); ++b) {
      const Eigen::Vector3d& a_m = graph.places[a].position_m;
      const Eigen::Vector3d& b_m = graph.places[b].position_m;
      if ((a_m - b_m).norm() > max_m) continue;
      const bool is_one_level = level_of[a] == level_of[b];
      if (is_one_level && !level_of[a]->isFree(a_m.head<2>(), b_m.head<2>(), 0.25)) continue;
      const double clearance_m = std::min(graph.places[a].clearance_m, graph.places[b].clearance_m);
      double least_m = clearance_m;
      for (double t = 0.0; is_one_level && t <= 1.0; t += 0.05) {
        const Eigen::Vector2d p_m = (a_m + t * (b_m - a_m)).head<2>();
        least_m = std::min(least_m, level_of[a]->computeClearance(p_m));
      }
      graph.edges.push_back({graph.places[a].id, graph.places[b].id, least_m});
    }
  }
  return graph;
}

double computeShortestWay(const PlanLevel& level, const PlanRect& extent,
                          const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m,
                          double radius_m, double lattice_m) {
  // The lattice goes through the start; the goal is joined to what it sees.
  const Eigen::Vector2d low = ((extent.min_m - from_m) / lattice_m).array().ceil();
  const Eigen::Vector2d high = ((extent.max_m - from_m) / lattice_m).array().floor();
  const int width = static_cast<int>(high.x() - low.x()) + 1;
  const int height = static_cast<int>(high.y() - low.y()) + 1;
  const auto at = [&](int cell) {
    return Eigen::Vector2d(from_m +
                           lattice_m * (low + Eigen::Vector2d(cell % width, cell / width)));
  };
  const auto directions = findDirections();
  std::vector<double> lengths_m(static_cast<std::size_t>(width * height),
                                std::numeric_limits<double>::infinity());
  using Item = std::pair<double, int>;
  std::priority_queue<Item, std::vector<Item>, std::greater<Item>> queue;
  const int start = static_cast<int>(-low.x()) + width * static_cast<int>(-low.y());
  lengths_m[static_cast<std::size_t>(start)] = 0.0;
  queue.emplace(0.0, start);
  double best_m = std::numeric_limits<double>::infinity();
  while (!queue.empty() && queue.top().first < best_m) {
    const auto [length_m, cell] = queue.top();
    queue.pop();
    if (length_m > lengths_m[static_cast<std::size_t>(cell)]) continue;
    const Eigen::Vector2d p_m = at(cell);
    const double rest_m = (to_m - p_m).norm();
    if (rest_m < 0.6 && level.isFree(p_m, to_m, radius_m)) {
      best_m = std::min(best_m, length_m + rest_m);
    }
    for (const auto& [dx, dy] : directions) {
      const int x = cell % width + dx;
      const int y = cell / width + dy;
      if (x < 0 || y < 0 || x >= width || y >= height) continue;
      const int next = x + width * y;
      const double next_m = length_m + lattice_m * std::hypot(dx, dy);
      if (next_m >= lengths_m[static_cast<std::size_t>(next)]) continue;
      if (!level.isFree(p_m, at(next), radius_m)) continue;
      lengths_m[static_cast<std::size_t>(next)] = next_m;
      queue.emplace(next_m, next);
    }
  }
  return best_m;
}

}  // namespace tsg::test
