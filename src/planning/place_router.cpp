// SPDX-License-Identifier: BSD-3-Clause
#include "place_router.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <unordered_map>

namespace tsg::planning {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kNoPlace = std::numeric_limits<std::size_t>::max();

/// Estimated length of the whole way, place; the smallest first.
using Queue =
    std::priority_queue<std::pair<double, std::size_t>, std::vector<std::pair<double, std::size_t>>,
                        std::greater<std::pair<double, std::size_t>>>;

/// Best known way from each place to a goal, if that goal is beside it.
std::vector<PlaceRouter::Join> findBestJoins(const std::vector<PlaceRouter::Join>& goals,
                                             std::size_t num_places) {
  std::vector<PlaceRouter::Join> best(num_places, {0, kInfinity, 0});
  for (const PlaceRouter::Join& goal : goals) {
    if (goal.length_m < best[goal.place].length_m) best[goal.place] = goal;
  }
  return best;
}

std::vector<std::size_t> traceBack(const std::vector<std::size_t>& parents, std::size_t last) {
  std::vector<std::size_t> places;
  for (std::size_t at = last; at != kNoPlace; at = parents[at]) places.push_back(at);
  std::reverse(places.begin(), places.end());
  return places;
}

}  // namespace

PlaceRouter::PlaceRouter(const PlaceGraph& graph) : first_edge_(graph.places.size() + 1, 0) {
  std::unordered_map<PlaceId, std::size_t> index;
  for (const Place& place : graph.places) {
    index.emplace(place.id, ids_.size());
    ids_.push_back(place.id);
    positions_m_.push_back(place.position_m);
    clearances_m_.push_back(place.clearance_m);
  }
  by_x_.resize(ids_.size());
  std::iota(by_x_.begin(), by_x_.end(), std::size_t{0});
  std::stable_sort(by_x_.begin(), by_x_.end(), [this](std::size_t a, std::size_t b) {
    return positions_m_[a].x() < positions_m_[b].x();
  });
  std::vector<std::pair<std::size_t, Edge>> edges;
  for (const PlaceEdge& edge : graph.edges) {
    const auto a = index.find(edge.a);
    const auto b = index.find(edge.b);
    if (a == index.end() || b == index.end()) continue;
    const auto length_m =
        static_cast<float>((positions_m_[a->second] - positions_m_[b->second]).norm());
    const auto clearance_m = static_cast<float>(edge.clearance_m);
    edges.push_back({a->second, {static_cast<std::uint32_t>(b->second), length_m, clearance_m}});
    edges.push_back({b->second, {static_cast<std::uint32_t>(a->second), length_m, clearance_m}});
  }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [from, edge] : edges) {
    ++first_edge_[from + 1];
    edges_.push_back(edge);
  }
  std::partial_sum(first_edge_.begin(), first_edge_.end(), first_edge_.begin());
}

std::vector<std::size_t> PlaceRouter::findNear(const Eigen::Vector3d& p_m,
                                               double max_distance_m) const {
  std::vector<std::pair<double, std::size_t>> near;
  auto at =
      std::lower_bound(by_x_.begin(), by_x_.end(), p_m.x() - max_distance_m,
                       [this](std::size_t place, double x) { return positions_m_[place].x() < x; });
  for (; at != by_x_.end() && positions_m_[*at].x() <= p_m.x() + max_distance_m; ++at) {
    const double away_m = (positions_m_[*at] - p_m).norm();
    if (away_m <= max_distance_m) near.emplace_back(away_m, *at);
  }
  std::sort(near.begin(), near.end());
  std::vector<std::size_t> places;
  for (const auto& item : near) places.push_back(item.second);
  return places;
}

std::optional<PlaceRouter::Route> PlaceRouter::findRoute(const std::vector<Join>& starts,
                                                         const std::vector<Join>& goals,
                                                         const Eigen::Vector3d& focus_m,
                                                         double reach_m, double radius_m) const {
  const std::vector<Join> exits = findBestJoins(goals, size());
  std::vector<double> lengths_m(size() + 1, kInfinity);  // the last stands for the goals
  std::vector<std::size_t> parents(size() + 1, kNoPlace);
  Queue queue;
  const auto relax = [&](std::size_t place, double length_m, std::size_t parent) {
    if (length_m >= lengths_m[place]) return;
    lengths_m[place] = length_m;
    parents[place] = parent;
    const double rest_m = place == size() ? 0.0 : (positions_m_[place] - focus_m).norm() - reach_m;
    queue.emplace(length_m + std::max(0.0, rest_m), place);
  };
  for (const Join& start : starts) relax(start.place, start.length_m, kNoPlace);
  std::vector<char> is_done(size() + 1, 0);
  while (!queue.empty()) {
    const std::size_t at = queue.top().second;
    queue.pop();
    if (at == size()) {
      auto places = traceBack(parents, parents[at]);
      const double clearance_m = computeClearance(places);
      return Route{std::move(places), exits[parents[at]].end, lengths_m[at], clearance_m};
    }
    if (std::exchange(is_done[at], 1) != 0) continue;
    if (exits[at].length_m < kInfinity) relax(size(), lengths_m[at] + exits[at].length_m, at);
    for (std::size_t i = first_edge_[at]; i < first_edge_[at + 1]; ++i) {
      if (static_cast<double>(edges_[i].clearance_m) + 1e-6 < radius_m) continue;
      relax(edges_[i].to, lengths_m[at] + static_cast<double>(edges_[i].length_m), at);
    }
  }
  return std::nullopt;
}

double PlaceRouter::computeClearance(const std::vector<std::size_t>& places) const {
  double least_m = kInfinity;
  for (std::size_t i = 0; i < places.size(); ++i) {
    least_m = std::min(least_m, clearances_m_[places[i]]);
    if (i + 1 == places.size()) break;
    double edge_m = 0.0;
    for (std::size_t e = first_edge_[places[i]]; e < first_edge_[places[i] + 1]; ++e) {
      if (edges_[e].to == places[i + 1]) {
        edge_m = std::max(edge_m, static_cast<double>(edges_[e].clearance_m));
      }
    }
    least_m = std::min(least_m, edge_m);
  }
  return least_m;
}

std::vector<char> PlaceRouter::findReached(const std::vector<Join>& starts, double radius_m) const {
  std::vector<char> is_reached(size(), 0);
  std::vector<std::size_t> open;
  const auto reach = [&](std::size_t place) {
    if (std::exchange(is_reached[place], 1) == 0) open.push_back(place);
  };
  for (const Join& start : starts) reach(start.place);
  while (!open.empty()) {
    const std::size_t at = open.back();
    open.pop_back();
    for (std::size_t i = first_edge_[at]; i < first_edge_[at + 1]; ++i) {
      if (static_cast<double>(edges_[i].clearance_m) + 1e-6 >= radius_m) reach(edges_[i].to);
    }
  }
  return is_reached;
}

}  // namespace tsg::planning
