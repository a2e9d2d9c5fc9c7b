// SPDX-License-Identifier: BSD-3-Clause
// Paths through a building of rooms of 5 x 5 m joined by doors, from corner to corner (rooms per
// side: 4, 20; the latter has 10000 places), beside Dijkstra over all cells of its ground plan.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "planning/navigation_grid.h"
#include "task_scene_graph/planning/planner.h"

namespace tsg::planning {
namespace {

using places::GroundPlan;
using places::PlanCell;

constexpr double kRoom_m = 5.0;
constexpr double kRadius_m = 0.25;

/// Signed distance of a wall lattice (0.2 m thick, doors of 0.9 m in the middle).
double computeWallDistance(double along_m, double across_m) {
  const double to_wall_m = std::abs(across_m - kRoom_m * std::round(across_m / kRoom_m)) - 0.1;
  const double to_door_m =
      std::abs(along_m - kRoom_m * std::floor(along_m / kRoom_m) - kRoom_m / 2.0) - 0.45;
  return to_door_m < 0.0 ? std::hypot(std::max(0.0, to_wall_m), to_door_m) : to_wall_m;
}

double computeClearance(double x_m, double y_m) {
  return std::min(computeWallDistance(x_m, y_m), computeWallDistance(y_m, x_m));
}

GroundPlan makePlan(int rooms) {
  GroundPlan plan(0.1);
  const int tiles = static_cast<int>(rooms * kRoom_m / 0.8) + 1;
  for (int x = 0; x < tiles; ++x) {
    for (int y = 0; y < tiles; ++y) {
      auto tile = std::make_shared<GroundPlan::Tile>();
      for (int i = 0; i < 64; ++i) {
        const auto p_m = plan.computeCenter({8 * x + i % 8, 8 * y + i / 8});
        const double clearance_m = computeClearance(p_m.x(), p_m.y());
        const bool is_inside = p_m.maxCoeff() < rooms * kRoom_m;
        const bool is_free = clearance_m > 0.0 && is_inside;
        (*tile)[static_cast<std::size_t>(i)] = {
            is_free ? PlanCell::State::kFree : PlanCell::State::kObstacle, 0.0F,
            is_free ? static_cast<float>(clearance_m) : 0.0F};
      }
      plan.setTiles({x, y}, {tile});
    }
  }
  return plan;
}

/// Least clearance of a line.
double computeLineClearance(const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m) {
  double least_m = std::numeric_limits<double>::infinity();
  for (double t = 0.0; t <= 1.0; t += 0.02) {
    const Eigen::Vector3d p_m = a_m + t * (b_m - a_m);
    least_m = std::min(least_m, computeClearance(p_m.x(), p_m.y()));
  }
  return least_m;
}

PlaceGraph makePlaces(int rooms) {
  PlaceGraph graph;
  const int side = static_cast<int>(rooms * kRoom_m);
  std::vector<std::uint64_t> ids(static_cast<std::size_t>(side * side));
  const auto at = [&](int x, int y) -> std::uint64_t& {
    return ids[static_cast<std::size_t>(x + side * y)];
  };
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const Eigen::Vector3d p_m(x + 0.55, y + 0.55, 0.5);
      at(x, y) = graph.places.size() + 1;
      graph.places.push_back({PlaceId{at(x, y)}, p_m, computeClearance(p_m.x(), p_m.y()), {}, 0});
    }
  }
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      for (const auto& [dx, dy] : {std::pair<int, int>{1, 0}, {0, 1}, {1, 1}, {-1, 1}}) {
        if (x + dx < 0 || x + dx >= side || y + dy >= side) continue;
        const PlaceId a{at(x, y)};
        const PlaceId b{at(x + dx, y + dy)};
        const double clearance_m = computeLineClearance(graph.places[a.value - 1].position_m,
                                                        graph.places[b.value - 1].position_m);
        if (clearance_m >= 0.25) graph.edges.push_back({a, b, clearance_m});
      }
    }
  }
  return graph;
}

PlanRequest makeRequest(int rooms) {
  const double far_m = rooms * kRoom_m - 1.0;
  return {{1.0, 1.0, 0.0}, {{far_m, far_m, 0.0}, {}}, kRadius_m};
}

void planPath(benchmark::State& state) {
  const int rooms = static_cast<int>(state.range(0));
  const PlaceGraph places = makePlaces(rooms);
  const Planner planner(places, makePlan(rooms), {});
  PlanResult result;
  for (auto _ : state) result = planner.plan(makeRequest(rooms));
  if (!result.isFound()) state.SkipWithError(result.message.c_str());
  state.counters["places"] = static_cast<double>(places.places.size());
  state.counters["length_m"] = result.path.length_m;
}
BENCHMARK(planPath)->ArgName("rooms_per_side")->Arg(4)->Arg(20)->Unit(benchmark::kMillisecond);

void makePlanner(benchmark::State& state) {
  const int rooms = static_cast<int>(state.range(0));
  const PlaceGraph places = makePlaces(rooms);
  const GroundPlan plan = makePlan(rooms);
  for (auto _ : state) benchmark::DoNotOptimize(Planner(places, plan, {}));
}
BENCHMARK(makePlanner)->ArgName("rooms_per_side")->Arg(4)->Arg(20)->Unit(benchmark::kMillisecond);

/// The peer: no places, no estimate, no smoothing. Its paths are those of a king.
void dijkstraOverCells(benchmark::State& state) {
  const int rooms = static_cast<int>(state.range(0));
  const NavigationGrid grid(makePlan(rooms), 0.2);
  const PlanRequest request = makeRequest(rooms);
  const NavigationGrid::Node goal = grid.findFloor(request.goal.position_m);
  float length = 0.0F;
  for (auto _ : state) {
    std::vector<float> lengths(grid.numNodes(), std::numeric_limits<float>::infinity());
    using Item = std::pair<float, NavigationGrid::Node>;
    std::priority_queue<Item, std::vector<Item>, std::greater<Item>> queue;
    const auto relax = [&](NavigationGrid::Node node, float to_node) {
      if (to_node >= lengths[node]) return;
      lengths[node] = to_node;
      queue.emplace(to_node, node);
    };
    relax(grid.findFloor(request.start_m), 0.0F);
    while (!queue.empty() && queue.top().second != goal) {
      const auto [so_far, at] = queue.top();
      queue.pop();
      if (so_far > lengths[at]) continue;
      for (int i = 0; i < 9; ++i) {
        const auto next = grid.findNeighbour(at, i % 3 - 1, i / 3 - 1);
        if (i == 4 || next == NavigationGrid::kNone || !grid.isPassable(next, kRadius_m)) continue;
        relax(next, so_far + (i % 2 == 0 ? 1.41421356F : 1.0F));
      }
    }
    length = lengths[goal];
  }
  state.counters["length_m"] = static_cast<double>(length) * grid.cellSize();
}
BENCHMARK(dijkstraOverCells)
    ->ArgName("rooms_per_side")
    ->Arg(4)
    ->Arg(20)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tsg::planning

BENCHMARK_MAIN();
