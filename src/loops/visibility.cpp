// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/visibility.h"

#include <algorithm>
#include <cmath>

namespace tsg::loops {
namespace {

constexpr double kMarginShare = 0.05;  ///< of the depth: what a surface seen at a slant differs by

CameraModel shrink(const CameraModel& camera, int cell_px) {
  const double scale = 1.0 / cell_px;
  CameraModel small = camera;
  small.width_px = camera.width_px / cell_px;
  small.height_px = camera.height_px / cell_px;
  small.fx_px *= scale;
  small.fy_px *= scale;
  small.cx_px = (camera.cx_px + 0.5) * scale - 0.5;
  small.cy_px = (camera.cy_px + 0.5) * scale - 0.5;
  return small;
}

float findNearest(const DepthImage& depth, int u_px, int v_px, int cell_px) {
  float nearest_m = 0.0F;
  int count = 0;
  for (int v = v_px; v < v_px + cell_px; ++v) {
    for (int u = u_px; u < u_px + cell_px; ++u) {
      const float z_m = depth.at(u, v);
      if (z_m <= 0.0F) continue;
      nearest_m = count == 0 ? z_m : std::min(nearest_m, z_m);
      ++count;
    }
  }
  return 2 * count >= cell_px * cell_px ? nearest_m : 0.0F;
}

enum class Sight { kNone, kMeasured, kThrough };

Sight look(const Eigen::Vector3d& p_camera, const DepthView& view, double margin_m) {
  const double z_m = p_camera.z();
  if (z_m <= margin_m) return Sight::kNone;
  const Eigen::Vector2d pixel = view.camera.project(p_camera);
  const auto u = static_cast<int>(std::lround(pixel.x()));
  const auto v = static_cast<int>(std::lround(pixel.y()));
  if (u < 0 || v < 0 || u >= view.camera.width_px || v >= view.camera.height_px)
    return Sight::kNone;
  const auto nearest_m = static_cast<double>(
      view.nearest_m[static_cast<std::size_t>(v) * static_cast<std::size_t>(view.camera.width_px) +
                     static_cast<std::size_t>(u)]);
  if (nearest_m <= 0.0) return Sight::kNone;
  const double reach_m = margin_m + kMarginShare * z_m;
  if (z_m < nearest_m - reach_m) return Sight::kThrough;
  return z_m < nearest_m + reach_m ? Sight::kMeasured : Sight::kNone;  // or it is hidden
}

}  // namespace

DepthView makeDepthView(const DepthImage& depth, const CameraModel& camera, int cell_px) {
  DepthView view;
  view.camera = shrink(camera, cell_px);
  view.nearest_m.reserve(static_cast<std::size_t>(view.camera.width_px) *
                         static_cast<std::size_t>(view.camera.height_px));
  for (int v = 0; v < view.camera.height_px; ++v) {
    for (int u = 0; u < view.camera.width_px; ++u) {
      view.nearest_m.push_back(findNearest(depth, u * cell_px, v * cell_px, cell_px));
    }
  }
  return view;
}

double Visibility::shareThrough() const {
  const auto total = static_cast<double>(num_seen + num_through);
  return total > 0.0 ? static_cast<double>(num_through) / total : 0.0;
}

Visibility lookAt(const Points& points, const Pose& T_views_points,
                  const std::vector<DepthView>& views, double margin_m) {
  std::vector<Pose> T_camera_points;
  for (const DepthView& view : views) {
    T_camera_points.push_back(view.T_scene_camera.inverse() * T_views_points);
  }
  Visibility result;
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d p = point.cast<double>();
    bool is_seen = false;
    bool is_through = false;
    for (std::size_t i = 0; i < views.size() && !is_seen; ++i) {
      const Sight sight = look(T_camera_points[i] * p, views[i], margin_m);
      is_seen = sight == Sight::kMeasured;
      is_through = is_through || sight == Sight::kThrough;
    }
    result.num_seen += is_seen ? 1 : 0;
    result.num_through += !is_seen && is_through ? 1 : 0;
  }
  return result;
}

Visibility operator+(const Visibility& a, const Visibility& b) {
  return {a.num_seen + b.num_seen, a.num_through + b.num_through};
}

}  // namespace tsg::loops
