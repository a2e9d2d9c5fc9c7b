// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/floor_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <queue>
#include <tuple>

namespace tsg::simulation {
namespace {

constexpr double kComfort_m = 0.6;  ///< ways nearer to obstacles than this cost more
const std::array<cv::Point, 8> kNeighbours = {cv::Point(1, 0),  cv::Point(-1, 0), cv::Point(0, 1),
                                              cv::Point(0, -1), cv::Point(1, 1),  cv::Point(1, -1),
                                              cv::Point(-1, 1), cv::Point(-1, -1)};

double lengthOf(cv::Point step) { return std::sqrt(static_cast<double>(step.dot(step))); }

}  // namespace

FloorMap::FloorMap(const Apartment& apartment, double low_m, double high_m) {
  Rect outline;
  for (const Room& room : apartment.rooms) outline.extend(room.interior_m);
  origin_m_ = outline.min().array() - 0.2;
  const Eigen::Vector2d size_m = outline.sizes().array() + 0.4;
  const auto cols = static_cast<int>(std::ceil(size_m.x() / cell_m_));
  const auto rows = static_cast<int>(std::ceil(size_m.y() / cell_m_));
  cv::Mat free(rows, cols, CV_8UC1, cv::Scalar(255));
  for (const Solid& solid : apartment.solids) {
    const Aabb box = computeBounds(solid);
    if (box.max().z() <= low_m || box.min().z() >= high_m) continue;
    const cv::Point a = toCell(box.min().head<2>());
    const cv::Point b = toCell(box.max().head<2>());
    cv::rectangle(free, a, b, cv::Scalar(0), cv::FILLED);
  }
  cv::rectangle(free, {0, 0}, {cols - 1, rows - 1}, cv::Scalar(0), 1);
  cv::distanceTransform(free, distance_m_, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  distance_m_ *= cell_m_;
}

cv::Point FloorMap::toCell(const Eigen::Vector2d& p_m) const {
  const Eigen::Vector2d cell = (p_m - origin_m_) / cell_m_;
  return {static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y()))};
}

Eigen::Vector2d FloorMap::toPoint(cv::Point cell) const {
  return origin_m_ + cell_m_ * Eigen::Vector2d(cell.x + 0.5, cell.y + 0.5);
}

bool FloorMap::isFree(cv::Point cell, double clearance_m) const {
  const bool inside =
      cell.x >= 0 && cell.y >= 0 && cell.x < distance_m_.cols && cell.y < distance_m_.rows;
  return inside && static_cast<double>(distance_m_.at<float>(cell)) >= clearance_m;
}

double FloorMap::computeClearance(const Eigen::Vector2d& p_m) const {
  const cv::Point cell = toCell(p_m);
  return isFree(cell, 0.0) ? static_cast<double>(distance_m_.at<float>(cell)) : 0.0;
}

bool FloorMap::isLineFree(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m,
                          double clearance_m) const {
  const int steps = std::max(1, static_cast<int>(std::ceil((b_m - a_m).norm() / (0.5 * cell_m_))));
  for (int i = 0; i <= steps; ++i) {
    if (!isFree(toCell(a_m + (b_m - a_m) * (static_cast<double>(i) / steps)), clearance_m))
      return false;
  }
  return true;
}

std::vector<Eigen::Vector2d> FloorMap::findPath(const Eigen::Vector2d& from_m,
                                                const Eigen::Vector2d& to_m,
                                                double clearance_m) const {
  const cv::Point start = toCell(from_m);
  const cv::Point goal = toCell(to_m);
  if (!isFree(start, clearance_m) || !isFree(goal, clearance_m)) return {};
  cv::Mat cost(distance_m_.size(), CV_64FC1, cv::Scalar(std::numeric_limits<double>::infinity()));
  cv::Mat parent(distance_m_.size(), CV_32SC2, cv::Scalar(-1, -1));
  using Entry = std::tuple<double, double, int, int>;  // estimate, cost, x, y: ties are decided
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  cost.at<double>(start) = 0.0;
  open.push({lengthOf(goal - start), 0.0, start.x, start.y});
  while (!open.empty()) {
    const auto [estimate, so_far, x, y] = open.top();
    open.pop();
    const cv::Point cell(x, y);
    if (cell == goal) break;
    if (so_far > cost.at<double>(cell)) continue;
    for (const cv::Point& step : kNeighbours) {
      const cv::Point next = cell + step;
      if (!isFree(next, clearance_m)) continue;
      const double near_m = kComfort_m - static_cast<double>(distance_m_.at<float>(next));
      const double new_cost = so_far + lengthOf(step) * (1.0 + 4.0 * std::max(0.0, near_m));
      if (new_cost >= cost.at<double>(next)) continue;
      cost.at<double>(next) = new_cost;
      parent.at<cv::Vec2i>(next) = {cell.x, cell.y};
      open.push({new_cost + lengthOf(goal - next), new_cost, next.x, next.y});
    }
  }
  if (!(cost.at<double>(goal) < std::numeric_limits<double>::infinity())) return {};
  std::vector<Eigen::Vector2d> path = {to_m};
  for (cv::Point c = goal; c != start;) {
    const cv::Vec2i before = parent.at<cv::Vec2i>(c);
    c = {before[0], before[1]};
    path.push_back(c == start ? from_m : toPoint(c));
  }
  std::reverse(path.begin(), path.end());
  return path;
}

std::vector<Eigen::Vector2d> FloorMap::findReachable(const Eigen::Vector2d& from_m,
                                                     double clearance_m) const {
  cv::Mat seen(distance_m_.size(), CV_8UC1, cv::Scalar(0));
  std::vector<cv::Point> stack;
  const auto visit = [&](cv::Point cell) {
    if (!isFree(cell, clearance_m) || seen.at<std::uint8_t>(cell) != 0) return;
    seen.at<std::uint8_t>(cell) = 1;
    stack.push_back(cell);
  };
  visit(toCell(from_m));
  while (!stack.empty()) {
    const cv::Point cell = stack.back();
    stack.pop_back();
    for (const cv::Point& step : kNeighbours) visit(cell + step);
  }
  std::vector<Eigen::Vector2d> points;
  for (int y = 0; y < seen.rows; ++y) {
    for (int x = 0; x < seen.cols; ++x) {
      if (seen.at<std::uint8_t>(y, x) != 0) points.push_back(toPoint({x, y}));
    }
  }
  return points;
}

}  // namespace tsg::simulation
