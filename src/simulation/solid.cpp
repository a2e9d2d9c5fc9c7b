// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/solid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tsg::simulation {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

double intersectCube(const UnitRay& ray) {
  double enter = -kNone;
  double leave = kNone;
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis];
    const double d = ray.direction[axis];
    if (d == 0.0) {
      if (std::abs(o) > 1.0) return kNone;
      continue;
    }
    const double inverse = 1.0 / d;
    const double side = d > 0.0 ? 1.0 : -1.0;
    enter = std::max(enter, (-side - o) * inverse);
    leave = std::min(leave, (side - o) * inverse);
  }
  return enter > 0.0 && enter <= leave ? enter : kNone;
}

double intersectSphere(const UnitRay& ray) {
  const double a = ray.direction.squaredNorm();
  const double b = ray.origin.dot(ray.direction);
  const double c = ray.origin.squaredNorm() - 1.0;
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) return kNone;
  const double t = (-b - std::sqrt(discriminant)) / a;
  return t > 0.0 ? t : kNone;
}

/// Where the ray crosses the plane z = height inside the disc of the given radius, from outside.
double intersectCap(const UnitRay& ray, double height, double radius) {
  const double dz = ray.direction.z();
  if (dz * height >= 0.0) return kNone;
  const double t = (height - ray.origin.z()) / dz;
  const double x = ray.origin.x() + t * ray.direction.x();
  const double y = ray.origin.y() + t * ray.direction.y();
  return t > 0.0 && x * x + y * y <= radius * radius ? t : kNone;
}

/// Side of the frustum x^2 + y^2 = (m + s z)^2 with m = (1 + k) / 2, s = (k - 1) / 2.
double intersectSide(const UnitRay& ray, double m, double s) {
  const Eigen::Vector3d& o = ray.origin;
  const Eigen::Vector3d& d = ray.direction;
  const double radius = m + s * o.z();
  const double growth = s * d.z();
  const double a = d.x() * d.x() + d.y() * d.y() - growth * growth;
  const double b = o.x() * d.x() + o.y() * d.y() - growth * radius;
  const double c = o.x() * o.x() + o.y() * o.y() - radius * radius;
  const auto accept = [&](double t) { return t > 0.0 && std::abs(o.z() + t * d.z()) <= 1.0; };
  if (std::abs(a) < 1e-12) {
    const double t = b < 0.0 ? -c / (2.0 * b) : kNone;
    return accept(t) ? t : kNone;
  }
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) return kNone;
  // Of both roots this is where the ray gets inside the nappe below the apex, for either sign of a.
  const double enter = (-b - std::sqrt(discriminant)) / a;
  return accept(enter) ? enter : kNone;
}

double intersectFrustum(const UnitRay& ray, double top_ratio) {
  const double side = intersectSide(ray, 0.5 * (1.0 + top_ratio), 0.5 * (top_ratio - 1.0));
  const double bottom = intersectCap(ray, -1.0, 1.0);
  const double top = intersectCap(ray, 1.0, top_ratio);
  return std::min({side, bottom, top});
}

double radiusAt(const Solid& solid, double z_unit) {
  return 0.5 * (1.0 + solid.top_ratio) + 0.5 * (solid.top_ratio - 1.0) * z_unit;
}

/// Half extents of the disc with the solid's x and y half sizes.
Eigen::Vector3d discExtents(const Eigen::Matrix3d& R, const Eigen::Vector3d& half) {
  return ((R.col(0) * half.x()).array().square() + (R.col(1) * half.y()).array().square()).sqrt();
}

}  // namespace

Aabb computeBounds(const Solid& solid, const Pose& T) {
  const Eigen::Matrix3d R = T.linear();
  const Eigen::Vector3d& half = solid.half_size_m;
  if (solid.shape == Shape::kFrustum) {
    const Eigen::Vector3d disc = discExtents(R, half);
    const Eigen::Vector3d axis = R.col(2) * half.z();
    const Eigen::Vector3d bottom = T.translation() - axis;
    const Eigen::Vector3d top = T.translation() + axis;
    Aabb box(bottom - disc, bottom + disc);
    return box.extend(Aabb(top - solid.top_ratio * disc, top + solid.top_ratio * disc));
  }
  const Eigen::Matrix3d scaled = R * half.asDiagonal();
  const Eigen::Vector3d extents = solid.shape == Shape::kBox
                                      ? Eigen::Vector3d(scaled.cwiseAbs().rowwise().sum())
                                      : Eigen::Vector3d(scaled.rowwise().norm());
  return Aabb(T.translation() - extents, T.translation() + extents);
}

bool isInside(const Solid& solid, const Eigen::Vector3d& p_world, double margin_m) {
  const Eigen::Vector3d half = solid.half_size_m.array() - margin_m;
  if (half.minCoeff() <= 0.0) return false;
  const Eigen::Vector3d p = (solid.T_world_solid.inverse() * p_world).cwiseQuotient(half);
  if (solid.shape == Shape::kBox) return p.cwiseAbs().maxCoeff() < 1.0;
  if (solid.shape == Shape::kEllipsoid) return p.squaredNorm() < 1.0;
  return std::abs(p.z()) < 1.0 && p.head<2>().norm() < radiusAt(solid, p.z());
}

double intersectUnit(Shape shape, double top_ratio, const UnitRay& ray) {
  if (shape == Shape::kBox) return intersectCube(ray);
  if (shape == Shape::kEllipsoid) return intersectSphere(ray);
  return intersectFrustum(ray, top_ratio);
}

Eigen::Vector3d computeNormal(const Solid& solid, const Eigen::Vector3d& p) {
  const Eigen::Vector3d& half = solid.half_size_m;
  Eigen::Vector3d n = Eigen::Vector3d::Zero();
  if (solid.shape == Shape::kBox) {
    int axis = 0;
    p.cwiseAbs().maxCoeff(&axis);
    n[axis] = p[axis] > 0.0 ? 1.0 : -1.0;
    return n;
  }
  if (solid.shape == Shape::kEllipsoid) return p.cwiseQuotient(half).normalized();
  const double radius = radiusAt(solid, p.z());
  const double below_side = radius - p.head<2>().norm();
  if (1.0 - std::abs(p.z()) <= below_side) return {0.0, 0.0, p.z() > 0.0 ? 1.0 : -1.0};
  // Gradient of x^2 + y^2 - r(z)^2.
  n << p.x(), p.y(), -radius * 0.5 * (solid.top_ratio - 1.0);
  return n.cwiseQuotient(half).normalized();
}

}  // namespace tsg::simulation
