// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "task_scene_graph/core/box.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/simulation/material.h"

namespace tsg::simulation {

constexpr double kPi = 3.14159265358979323846;

enum class Shape {
  kBox,        ///< |x| <= hx, |y| <= hy, |z| <= hz
  kEllipsoid,  ///< (x/hx)^2 + (y/hy)^2 + (z/hz)^2 <= 1
  kFrustum     ///< |z| <= hz, (x/hx)^2 + (y/hy)^2 <= r(z)^2, r from 1 (bottom) to top_ratio (top)
};

/// A convex body with a closed-form surface. Its frame has the origin in the middle of its height.
struct Solid {
  Shape shape = Shape::kBox;
  Pose T_world_solid = Pose::Identity();
  Eigen::Vector3d half_size_m = Eigen::Vector3d::Ones();
  double top_ratio = 1.0;  ///< of a frustum, in [0, 1]; 1 = cylinder, 0 = cone
  Material material;
  std::uint16_t instance = 0;  ///< 0 = structure (walls, floor, ceiling)
  std::uint16_t part = 0;      ///< index into Apartment::parts plus 1; 0 = structure
};

/// Smallest axis-aligned box of the solid after `T`, exact for every shape, in the frame T maps to.
Aabb computeBounds(const Solid& solid, const Pose& T_frame_solid);
inline Aabb computeBounds(const Solid& solid) { return computeBounds(solid, solid.T_world_solid); }

/// True for a point (world frame, metres) inside the solid by more than `margin_m` along each of
/// its axes (for a positive margin, the solid with its half sizes reduced by it).
bool isInside(const Solid& solid, const Eigen::Vector3d& p_world, double margin_m = 0.0);

/// A ray in the solid's frame with every axis divided by the half size, where the shapes are the
/// unit cube, the unit sphere and a unit frustum. Lengths along the ray are unchanged.
struct UnitRay {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

/// Smallest t > 0 with origin + t * direction on the surface, where the ray enters the solid;
/// infinity if it does not enter.
double intersectUnit(Shape shape, double top_ratio, const UnitRay& ray);

/// Outward unit normal in the solid's frame at a point on its surface (unit coordinates).
Eigen::Vector3d computeNormal(const Solid& solid, const Eigen::Vector3d& p_unit);

}  // namespace tsg::simulation
