// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "task_scene_graph/simulation/apartment.h"

namespace tsg::simulation::test {

/// Independent of the closed forms: walks along the ray in small steps until a point lies inside
/// the solid, then bisects. Infinity if no step lands inside.
inline double marchRay(const Solid& solid, const Eigen::Vector3d& origin,
                       const Eigen::Vector3d& direction, double step) {
  const double scale = direction.norm();
  const double reach = solid.half_size_m.norm() / scale;
  const double middle =
      (solid.T_world_solid.translation() - origin).dot(direction) / (scale * scale);
  double before = std::max(0.0, middle - reach);
  for (double t = before + step; t <= middle + reach; t += step) {
    if (isInside(solid, origin + t * direction)) {
      double low = before;
      double high = t;
      for (int i = 0; i < 40; ++i) {
        const double half = 0.5 * (low + high);
        (isInside(solid, origin + half * direction) ? high : low) = half;
      }
      return high;
    }
    before = t;
  }
  return std::numeric_limits<double>::infinity();
}

/// Points on the surface, world frame: `n` x `n` directions or grid points on each face.
inline std::vector<Eigen::Vector3d> sampleSurface(const Solid& solid, int n) {
  std::vector<Eigen::Vector3d> points;
  const auto add = [&](const Eigen::Vector3d& p_unit) {
    points.push_back(solid.T_world_solid * p_unit.cwiseProduct(solid.half_size_m));
  };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const double a = -1.0 + 2.0 * i / n;
      const double angle = 2.0 * kPi * j / n;
      const double b = -1.0 + 2.0 * j / n;
      if (solid.shape == Shape::kBox) {
        for (const double s : {-1.0, 1.0}) {
          add({s, a, b});
          add({a, s, b});
          add({a, b, s});
        }
      } else if (solid.shape == Shape::kEllipsoid) {
        const double r = std::sqrt(std::max(0.0, 1.0 - a * a));
        add({r * std::cos(angle), r * std::sin(angle), a});
      } else {
        const double r = 0.5 * (1.0 + solid.top_ratio) + 0.5 * (solid.top_ratio - 1.0) * a;
        add({r * std::cos(angle), r * std::sin(angle), a});
        const double inner = 0.5 * (1.0 + a);
        add({inner * std::cos(angle), inner * std::sin(angle), -1.0});
        add({inner * solid.top_ratio * std::cos(angle), inner * solid.top_ratio * std::sin(angle),
             1.0});
      }
    }
  }
  return points;
}

/// Names an instance whose surface reaches into another one or into the structure, and the other;
/// empty if there is none.
inline std::string findIntrusion(const Apartment& apartment) {
  const auto nameOf = [&](const Solid& solid) {
    return solid.instance == 0 ? "structure" : apartment.instances[solid.instance - 1U].phrase;
  };
  for (const Solid& solid : apartment.solids) {
    if (solid.instance == 0) continue;
    const auto points = sampleSurface(solid, 8);
    for (const Solid& other : apartment.solids) {
      if (solid.instance == other.instance) continue;
      if (!hasOverlap(computeBounds(solid), computeBounds(other))) continue;
      for (const Eigen::Vector3d& p : points) {
        if (isInside(other, p, 1e-4)) return nameOf(solid) + " in " + nameOf(other);
      }
    }
  }
  return "";
}

}  // namespace tsg::simulation::test
