// SPDX-License-Identifier: BSD-3-Clause
#include "footprint.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace tsg::scene_graph {
namespace {

constexpr double kCell_m = 0.1;
constexpr double kMaxCells = 1000.0;  // along a side

/// A raster of the plan, one cell wider than what is drawn on each side.
struct Raster {
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  ///< of cell (0, 0): its centre
  double cell_m = kCell_m;
  cv::Mat cells;  ///< CV_8UC1, column = x, row = y
};

Raster makeRaster(const std::vector<const Place*>& places) {
  Eigen::AlignedBox2d box;
  for (const Place* place : places) {
    const Eigen::Vector2d reach_m = Eigen::Vector2d::Constant(std::max(place->clearance_m, 0.0));
    box.extend(Eigen::Vector2d(place->position_m.head<2>() - reach_m));
    box.extend(Eigen::Vector2d(place->position_m.head<2>() + reach_m));
  }
  Raster raster;
  raster.cell_m = std::max(kCell_m, box.sizes().maxCoeff() / kMaxCells);
  raster.origin_m = box.min() - Eigen::Vector2d::Constant(raster.cell_m);
  const Eigen::Vector2i size = (box.sizes() / raster.cell_m).array().ceil().cast<int>() + 3;
  raster.cells = cv::Mat::zeros(size.y(), size.x(), CV_8UC1);
  return raster;
}

void drawDisc(const Place& place, Raster& raster) {
  const Eigen::Vector2d center = (place.position_m.head<2>() - raster.origin_m) / raster.cell_m;
  const double radius = place.clearance_m / raster.cell_m;
  const int last = static_cast<int>(std::floor(center.y() + radius));
  for (int y = static_cast<int>(std::ceil(center.y() - radius)); y <= last; ++y) {
    const double half = std::sqrt(std::max(0.0, radius * radius - std::pow(y - center.y(), 2)));
    const int from = static_cast<int>(std::ceil(center.x() - half));
    const int to = static_cast<int>(std::floor(center.x() + half));
    std::uint8_t* row = raster.cells.ptr<std::uint8_t>(y);
    if (to >= from) std::fill(row + from, row + to + 1, std::uint8_t{1});
  }
}

std::vector<cv::Point> findLargestOutline(const cv::Mat& cells) {
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(cells.clone(), outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  if (outlines.empty()) return {};
  return *std::max_element(outlines.begin(), outlines.end(), [](const auto& a, const auto& b) {
    return cv::contourArea(a) < cv::contourArea(b);
  });
}

}  // namespace

Footprint computeFootprint(const std::vector<const Place*>& places) {
  if (places.empty()) return {};
  Raster raster = makeRaster(places);
  for (const Place* place : places) drawDisc(*place, raster);
  Footprint footprint;
  footprint.area_m2 = cv::countNonZero(raster.cells) * raster.cell_m * raster.cell_m;
  std::vector<cv::Point> outline = findLargestOutline(raster.cells);
  if (outline.size() < 3) return footprint;
  if (cv::contourArea(outline, true) < 0.0) std::reverse(outline.begin(), outline.end());
  for (const cv::Point& point : outline) {
    footprint.outline_m.push_back(raster.origin_m +
                                  raster.cell_m * Eigen::Vector2d(point.x, point.y));
  }
  return footprint;
}

}  // namespace tsg::scene_graph
