// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/material.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tsg::simulation {
namespace {

float hashCell(std::int64_t x, std::int64_t y) {
  auto h =
      static_cast<std::uint32_t>(x) * 0x8da6b343U ^ static_cast<std::uint32_t>(y) * 0xd8163841U;
  h = (h ^ (h >> 15)) * 0x2c1b3c6dU;
  h = (h ^ (h >> 12)) * 0x297a2d39U;
  return static_cast<float>((h ^ (h >> 15)) >> 8) * (1.0F / 16777216.0F);
}

/// Texture axes of the face that the normal points out of: the two other axes, in metres.
Eigen::Vector2d pickAxes(const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
  const Eigen::Vector3d a = n.cwiseAbs();
  if (a.z() >= a.x() && a.z() >= a.y()) return {p.x(), p.y()};
  if (a.y() >= a.x()) return {p.x(), p.z()};
  return {p.y(), p.z()};
}

/// Distance to the nearest multiple of the period, as a share of the period.
double distanceToLine(double value, double period) {
  const double share = value / period;
  return std::abs(share - std::floor(share + 0.5));
}

float computeGrain(double along_m, double across_m) {
  return 0.9F + 0.2F * computeNoise(along_m * 3.0, across_m * 55.0);
}

Color computePlanks(const Material& m, double u, double v) {
  const double row = std::floor(v / static_cast<double>(m.scale_m));
  const double length_m = 1.3;
  const double shifted_m = u + row * 0.47;
  const double board = std::floor(shifted_m / length_m);
  const auto tint =
      0.85F + 0.25F * hashCell(static_cast<std::int64_t>(row), static_cast<std::int64_t>(board));
  const bool gap = distanceToLine(v, static_cast<double>(m.scale_m)) < 0.015 ||
                   distanceToLine(shifted_m, length_m) < 0.0015;
  return m.color * (gap ? 0.55F : tint * computeGrain(u + board * 7.0, v + row * 3.0));
}

Color computeTiles(const Material& m, double u, double v) {
  const auto size_m = static_cast<double>(m.scale_m);
  if (std::min(distanceToLine(u, size_m), distanceToLine(v, size_m)) < 0.03) return m.second;
  const auto tint =
      hashCell(std::llround(std::floor(u / size_m)), std::llround(std::floor(v / size_m)));
  return m.color * (0.94F + 0.08F * tint);
}

/// Hills under a sky; v is measured from the middle of the picture.
Color computePicture(const Material& m, double u, double v) {
  const double hill_m = 0.12 * (static_cast<double>(computeNoise(u * 6.0 + 11.0, 0.5)) - 0.5);
  if (v > hill_m)
    return Color(0.55F, 0.75F, 0.95F) * (0.8F + 0.2F * computeNoise(u * 9.0, v * 14.0));
  const float shade = 0.7F + 0.5F * computeNoise(u * 25.0, v * 25.0);
  return (v > hill_m - 0.06 ? m.color : m.second) * shade;
}

Color computeSky(const Material& m, double v) {
  const auto share = static_cast<float>(std::clamp(0.5 + v, 0.0, 1.0));
  return m.color * share + Color(0.95F, 0.97F, 1.0F) * (1.0F - share);
}

}  // namespace

float computeNoise(double x, double y) {
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  const auto ix = static_cast<std::int64_t>(fx);
  const auto iy = static_cast<std::int64_t>(fy);
  const auto u = static_cast<float>(x - fx);
  const auto v = static_cast<float>(y - fy);
  const float su = u * u * (3.0F - 2.0F * u);
  const float sv = v * v * (3.0F - 2.0F * v);
  const float bottom = hashCell(ix, iy) * (1.0F - su) + hashCell(ix + 1, iy) * su;
  const float top = hashCell(ix, iy + 1) * (1.0F - su) + hashCell(ix + 1, iy + 1) * su;
  return bottom * (1.0F - sv) + top * sv;
}

Color computeAlbedo(const Material& m, const Eigen::Vector3d& p_m, const Eigen::Vector3d& normal) {
  if (m.pattern == Pattern::kPlain || m.pattern == Pattern::kWall) return m.color;
  const Eigen::Vector2d uv = pickAxes(p_m, normal);
  switch (m.pattern) {
    case Pattern::kWood:
      return m.color * computeGrain(uv.x(), uv.y());
    case Pattern::kPlanks:
      return computePlanks(m, uv.x(), uv.y());
    case Pattern::kTiles:
      return computeTiles(m, uv.x(), uv.y());
    case Pattern::kStripes: {
      const double cell = std::floor(uv.x() / static_cast<double>(m.scale_m));
      return std::fmod(std::abs(cell), 2.0) < 0.5 ? m.color : m.second;
    }
    case Pattern::kFabric:
      return m.color * (0.82F + 0.3F * computeNoise(uv.x() * 160.0, uv.y() * 160.0));
    case Pattern::kPicture:
      return computePicture(m, uv.x(), uv.y());
    case Pattern::kSky:
      return computeSky(m, uv.y());
    default:
      return m.color;
  }
}

}  // namespace tsg::simulation
