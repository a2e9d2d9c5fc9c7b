// SPDX-License-Identifier: BSD-3-Clause
#include "view_solids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace tsg::simulation {
namespace {

constexpr double kNear_m = 0.02;  ///< nothing closer is seen

using Corners = std::array<Eigen::Vector3d, 8>;

/// Pixels that the convex hull of the corners covers, after cutting it at the near plane.
cv::Rect projectHull(const Corners& corners, const CameraModel& camera) {
  Eigen::AlignedBox2d seen;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d& a = corners[static_cast<std::size_t>(i)];
    if (a.z() >= kNear_m) seen.extend(camera.project(a));
    for (const int bit : {1, 2, 4}) {
      const Eigen::Vector3d& b = corners[static_cast<std::size_t>(i ^ bit)];
      if ((a.z() >= kNear_m) == (b.z() >= kNear_m)) continue;
      const Eigen::Vector3d cut = a + (b - a) * ((kNear_m - a.z()) / (b.z() - a.z()));
      seen.extend(camera.project(Eigen::Vector3d(cut.x(), cut.y(), kNear_m)));
    }
  }
  if (seen.isEmpty()) return {};
  // One pixel more on each side: edges are sampled between pixels.
  const Eigen::Vector2d size(camera.width_px, camera.height_px);
  const Eigen::Vector2d low = (seen.min().array() - 1.0).max(0.0).min(size.array());
  const Eigen::Vector2d high = (seen.max().array() + 2.0).max(0.0).min(size.array());
  const cv::Point a(static_cast<int>(low.x()), static_cast<int>(low.y()));
  const cv::Point b(static_cast<int>(std::ceil(high.x())), static_cast<int>(std::ceil(high.y())));
  return {a, b};
}

}  // namespace

ViewSolids::ViewSolids(const std::vector<Solid>& solids, const CameraModel& camera,
                       const Pose& T_world_camera) {
  const Pose T_camera_world = T_world_camera.inverse();
  seen_.reserve(solids.size());
  for (const Solid& solid : solids)
    seen_.push_back(computeSeenSolid(solid, camera, T_camera_world));
  fillTiles(camera);
}

ViewSolids::SeenSolid ViewSolids::computeSeenSolid(const Solid& solid, const CameraModel& camera,
                                                   const Pose& T_camera_world) const {
  const Pose T_camera_solid = T_camera_world * solid.T_world_solid;
  Corners corners;
  SeenSolid seen;
  seen.nearest_m = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d side((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0,
                               (i & 4) != 0 ? 1.0 : -1.0);
    Eigen::Vector3d& corner = corners[static_cast<std::size_t>(i)];
    corner = T_camera_solid * side.cwiseProduct(solid.half_size_m);
    seen.nearest_m = std::min(seen.nearest_m, corner.z());
  }
  seen.shape = solid.shape;
  seen.top_ratio = solid.top_ratio;
  seen.pixels = projectHull(corners, camera);
  const Pose T_solid_camera = T_camera_solid.inverse();
  const Eigen::Vector3d scale = solid.half_size_m.cwiseInverse();
  seen.unit_from_camera = scale.asDiagonal() * T_solid_camera.linear();
  seen.origin = scale.cwiseProduct(T_solid_camera.translation());
  return seen;
}

void ViewSolids::fillTiles(const CameraModel& camera) {
  tile_columns_ = (camera.width_px - 1) / kTile_px + 1;
  const int tile_rows = (camera.height_px - 1) / kTile_px + 1;
  tiles_.resize(static_cast<std::size_t>(tile_columns_ * tile_rows));
  std::vector<int> order(seen_.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [this](int a, int b) {
    return seen_[static_cast<std::size_t>(a)].nearest_m <
           seen_[static_cast<std::size_t>(b)].nearest_m;
  });
  for (const int index : order) {
    const cv::Rect& pixels = seen_[static_cast<std::size_t>(index)].pixels;
    if (pixels.empty()) continue;
    for (int y = pixels.y / kTile_px; y <= (pixels.br().y - 1) / kTile_px; ++y) {
      for (int x = pixels.x / kTile_px; x <= (pixels.br().x - 1) / kTile_px; ++x) {
        tiles_[static_cast<std::size_t>(y * tile_columns_ + x)].push_back(index);
      }
    }
  }
}

ViewSolids::Hit ViewSolids::cast(const Eigen::Vector3d& direction, int u_px, int v_px) const {
  const auto& tile =
      tiles_[static_cast<std::size_t>((v_px / kTile_px) * tile_columns_ + u_px / kTile_px)];
  Hit hit;
  hit.depth_m = std::numeric_limits<double>::infinity();
  for (const int index : tile) {
    const SeenSolid& seen = seen_[static_cast<std::size_t>(index)];
    if (seen.nearest_m > hit.depth_m) break;
    if (!seen.pixels.contains(cv::Point(u_px, v_px))) continue;
    const UnitRay ray{seen.origin, seen.unit_from_camera * direction};
    const double t = intersectUnit(seen.shape, seen.top_ratio, ray);
    if (t < hit.depth_m || (t == hit.depth_m && index < hit.index)) hit = {index, t};
  }
  return hit;
}

}  // namespace tsg::simulation
