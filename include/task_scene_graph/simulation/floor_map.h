// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "task_scene_graph/simulation/apartment.h"

namespace tsg::simulation {

/// Where someone of a given height can walk: a grid of distances to the nearest obstacle.
class FloorMap {
 public:
  /// Solids count as obstacles, by their bounding boxes, where they reach between `low_m` and
  /// `high_m` (world z). O(cells + solids).
  explicit FloorMap(const Apartment& apartment, double low_m = 0.05, double high_m = 1.75);

  /// Distance from the centre of the point's cell to the nearest obstacle cell, metres; 0 outside.
  double computeClearance(const Eigen::Vector2d& p_m) const;
  /// True if every cell under the straight line has at least the clearance.
  bool isLineFree(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m, double clearance_m) const;
  /// Shortest way (A* over the 8-neighbourhood, ways close to obstacles cost more) through cells
  /// with at least `clearance_m`, both ends included. Empty if there is none. O(cells log cells).
  std::vector<Eigen::Vector2d> findPath(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m,
                                        double clearance_m) const;
  /// Centres of all cells with the clearance that can be reached from a point, row by row.
  std::vector<Eigen::Vector2d> findReachable(const Eigen::Vector2d& from_m,
                                             double clearance_m) const;
  double cellSize() const { return cell_m_; }

 private:
  cv::Point toCell(const Eigen::Vector2d& p_m) const;
  Eigen::Vector2d toPoint(cv::Point cell) const;
  bool isFree(cv::Point cell, double clearance_m) const;

  double cell_m_ = 0.05;
  Eigen::Vector2d origin_m_ = Eigen::Vector2d::Zero();
  cv::Mat distance_m_;  // CV_32FC1
};

}  // namespace tsg::simulation
