// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/places/view_database.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tsg::places {
namespace {

constexpr double kNearestView_m = 0.5;  ///< nearer views do not count for more

/// Of every second pixel of every second row.
std::uint16_t computeMedian_mm(const DepthImage& depth, const cv::Rect& tile) {
  std::array<float, View::kTile_px * View::kTile_px / 4> values_m{};
  std::ptrdiff_t count = 0;
  for (int v = tile.y; v < tile.y + tile.height; v += 2) {
    for (int u = tile.x; u < tile.x + tile.width; u += 2) {
      const float depth_m = depth.at(u, v);
      if (depth_m > 0.0F) values_m[static_cast<std::size_t>(count++)] = depth_m;
    }
  }
  if (count == 0) return 0;
  const auto middle = values_m.begin() + count / 2;
  std::nth_element(values_m.begin(), middle, values_m.begin() + count);
  return static_cast<std::uint16_t>(std::clamp(std::lround(*middle * 1000.0F), 1L, 65535L));
}

}  // namespace

bool View::sees(const Eigen::Vector3d& p_world, double max_range_m, double tolerance_m) const {
  const Eigen::Vector3d p_camera = T_camera_world * p_world;
  if (p_camera.z() <= 0.0 || p_camera.squaredNorm() > max_range_m * max_range_m) return false;
  const Eigen::Vector2d pixel = camera.project(p_camera);
  const Eigen::Vector2d size(camera.width_px, camera.height_px);
  if ((pixel.array() < -0.5).any() || (pixel.array() >= size.array() - 0.5).any()) return false;
  const int u_px = static_cast<int>(pixel.x() + 0.5);
  const int v_px = static_cast<int>(pixel.y() + 0.5);
  const int tile = v_px / kTile_px * tiles_per_row + u_px / kTile_px;
  const std::uint16_t measured_mm = depth_mm[static_cast<std::size_t>(tile)];
  return measured_mm == 0 || p_camera.z() <= 0.001 * measured_mm + tolerance_m;
}

View makeView(const RgbdFrame& frame, const Embedding& embedding) {
  View view;
  view.camera = frame.camera;
  view.T_camera_world = frame.T_world_camera.inverse();
  view.tiles_per_row = (frame.camera.width_px + View::kTile_px - 1) / View::kTile_px;
  view.embedding = embedding;
  const cv::Rect image(0, 0, frame.camera.width_px, frame.camera.height_px);
  for (int v = 0; v < image.height; v += View::kTile_px) {
    for (int u = 0; u < image.width; u += View::kTile_px) {
      const cv::Rect tile = cv::Rect(u, v, View::kTile_px, View::kTile_px) & image;
      view.depth_mm.push_back(computeMedian_mm(frame.depth, tile));
    }
  }
  return view;
}

double computeViewWeight(double distance_m, ViewWeighting weighting) {
  if (weighting != ViewWeighting::kInverseSquare) return 1.0;
  const double d_m = std::max(distance_m, kNearestView_m);
  return 1.0 / (d_m * d_m);
}

void ViewSum::add(const Embedding& embedding, double distance_m, ViewWeighting weighting) {
  const bool is_nearest = count == 0 || distance_m < nearest_m;
  if (is_nearest) nearest_m = distance_m;
  ++count;
  const double w = computeViewWeight(distance_m, weighting);
  if (sum.size() == 0 || (weighting == ViewWeighting::kClosest && is_nearest)) {
    sum = static_cast<float>(w) * embedding;
    weight = w;
  } else if (weighting != ViewWeighting::kClosest) {
    sum += static_cast<float>(w) * embedding;
    weight += w;
  }
}

Embedding ViewSum::computeMean() const {
  if (count == 0) return {};
  return sum / static_cast<float>(weight);
}

const View& ViewDatabase::add(View view) {
  if (views_.size() == max_views_) {
    views_.pop_front();
    ++forgotten_;
  }
  views_.push_back(std::move(view));
  return views_.back();
}

bool ViewDatabase::addTo(ViewSum& sum, const View& view, const Eigen::Vector3d& p_world) const {
  if (!sees(view, p_world)) return false;
  sum.add(view.embedding, (view.T_camera_world * p_world).norm(), weighting_);
  return true;
}

ViewSum ViewDatabase::collect(const Eigen::Vector3d& p_world) const {
  ViewSum sum;
  for (const View& view : views_) {
    addTo(sum, view, p_world);
  }
  return sum;
}

}  // namespace tsg::places
