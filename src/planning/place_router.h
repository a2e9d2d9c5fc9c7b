// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "task_scene_graph/core/primitives.h"

namespace tsg::planning {

/// Shortest ways over a place graph. Immutable.
class PlaceRouter {
 public:
  /// An end of a way (start or goal) that is joined to a place.
  struct Join {
    std::size_t place = 0;  ///< index
    double length_m = 0.0;
    std::size_t end = 0;  ///< which of several goals
  };

  struct Route {
    std::vector<std::size_t> places;  ///< indices, from the start's to the goal's
    std::size_t goal = 0;             ///< the `end` that was reached
    double length_m = 0.0;
    double clearance_m = 0.0;  ///< least of its edges and places
  };

  /// Copies what it needs: O(places * log(places) + edges). Edges to places that are not there are
  /// left out.
  explicit PlaceRouter(const PlaceGraph& graph);

  std::size_t size() const { return positions_m_.size(); }
  PlaceId id(std::size_t place) const { return ids_[place]; }
  const Eigen::Vector3d& position(std::size_t place) const { return positions_m_[place]; }

  /// Places at most `max_distance_m` away, nearest first. O(places whose x is so near).
  std::vector<std::size_t> findNear(const Eigen::Vector3d& p_m, double max_distance_m) const;

  /// Shortest way (A*) over edges with `radius_m` of clearance.
  /// @param focus_m  every goal lies within `reach_m` of it
  std::optional<Route> findRoute(const std::vector<Join>& starts, const std::vector<Join>& goals,
                                 const Eigen::Vector3d& focus_m, double reach_m,
                                 double radius_m) const;

  /// For each place whether a way leads there from `starts`.
  std::vector<char> findReached(const std::vector<Join>& starts, double radius_m) const;

 private:
  double computeClearance(const std::vector<std::size_t>& places) const;

  struct Edge {
    std::uint32_t to = 0;
    float length_m = 0.0F;
    float clearance_m = 0.0F;
  };

  std::vector<PlaceId> ids_;
  std::vector<Eigen::Vector3d> positions_m_;
  std::vector<double> clearances_m_;
  std::vector<std::size_t> by_x_;
  std::vector<std::size_t> first_edge_;  ///< of each place, and one past the last
  std::vector<Edge> edges_;
};

}  // namespace tsg::planning
