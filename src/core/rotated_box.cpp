// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/rotated_box.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tsg {
namespace {

using Polygon = std::vector<Eigen::Vector3d>;  // convex, its corners in order
using Polyhedron = std::vector<Polygon>;       // convex, its faces

struct HalfSpace {
  Eigen::Vector3d normal;
  double offset_m;  ///< inside: normal . p <= offset

  double computeDistance(const Eigen::Vector3d& p) const { return normal.dot(p) - offset_m; }
};

Polyhedron makeFaces(const RotatedBox& box, const Eigen::Vector3d& origin_m) {
  constexpr int kCorners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  Polyhedron faces;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      Polygon face;
      for (const auto& [u, v] : kCorners) {
        Eigen::Vector3d corner;
        corner[axis] = side;
        corner[(axis + 1) % 3] = u;
        corner[(axis + 2) % 3] = v;
        const Eigen::Vector3d p_box = corner.cwiseProduct(box.size_m) / 2.0;
        face.emplace_back(box.center_m - origin_m + box.rotation * p_box);
      }
      faces.push_back(face);
    }
  }
  return faces;
}

std::vector<HalfSpace> makeHalfSpaces(const RotatedBox& box, const Eigen::Vector3d& origin_m) {
  std::vector<HalfSpace> spaces;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector3d normal = side * box.rotation.col(axis);
      spaces.push_back({normal, normal.dot(box.center_m - origin_m) + box.size_m[axis] / 2.0});
    }
  }
  return spaces;
}

/// The part of a face inside; what of its outline lies on the plane is appended to `cap`.
Polygon clipFace(const Polygon& face, const HalfSpace& space, Polygon& cap) {
  Polygon part;
  for (std::size_t i = 0; i < face.size(); ++i) {
    const Eigen::Vector3d& a = face[i];
    const Eigen::Vector3d& b = face[(i + 1) % face.size()];
    const double distance_a = space.computeDistance(a);
    const double distance_b = space.computeDistance(b);
    if (distance_a <= 0.0) part.push_back(a);
    if (distance_a == 0.0) cap.push_back(a);
    if ((distance_a < 0.0) == (distance_b < 0.0) || distance_a * distance_b == 0.0) continue;
    const Eigen::Vector3d cut = a + (b - a) * (distance_a / (distance_a - distance_b));
    part.push_back(cut);
    cap.push_back(cut);
  }
  return part;
}

Eigen::Vector3d computeMean(const Polygon& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

/// Points of a plane in the order of a convex outline.
void sortAround(const Eigen::Vector3d& normal, Polygon& points) {
  const Eigen::Vector3d center = computeMean(points);
  const Eigen::Vector3d u = normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.cross(u);
  const auto angle = [&](const Eigen::Vector3d& p) {
    return std::atan2(v.dot(p - center), u.dot(p - center));
  };
  std::sort(points.begin(), points.end(), [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return angle(a) < angle(b);
  });
}

Polyhedron clip(const Polyhedron& solid, const HalfSpace& space) {
  Polyhedron kept;
  Polygon cap;
  bool is_cut = false;
  for (const Polygon& face : solid) {
    is_cut = is_cut || std::any_of(face.begin(), face.end(), [&](const Eigen::Vector3d& p) {
               return space.computeDistance(p) > 0.0;
             });
    Polygon part = clipFace(face, space, cap);
    if (part.size() >= 3) kept.push_back(std::move(part));
  }
  if (!is_cut) return solid;
  if (cap.size() < 3) return kept;
  sortAround(space.normal, cap);
  kept.push_back(std::move(cap));
  return kept;
}

/// Twice the area, along the face's normal.
Eigen::Vector3d computeDoubleArea(const Polygon& face) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < face.size(); ++i) {
    sum += (face[i] - face[0]).cross(face[i + 1] - face[0]);
  }
  return sum;
}

/// Pyramids over the faces, their tip inside.
double computeVolume(const Polyhedron& solid) {
  if (solid.empty()) return 0.0;
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();
  for (const Polygon& face : solid) tip += computeMean(face);
  tip /= static_cast<double>(solid.size());
  double six_volumes = 0.0;
  for (const Polygon& face : solid) {
    six_volumes += std::abs(computeDoubleArea(face).dot(face[0] - tip));
  }
  return six_volumes / 6.0;
}

}  // namespace

bool RotatedBox::contains(const Eigen::Vector3d& p_world) const {
  const Eigen::Vector3d p_box = rotation.transpose() * (p_world - center_m);
  return (p_box.cwiseAbs().array() <= size_m.array() / 2.0).all();
}

RotatedBox toRotatedBox(const OrientedBox& box) {
  return {box.center_m, box.size_m, box.rotation()};
}

double computeIntersectionVolume(const RotatedBox& a, const RotatedBox& b) {
  // Around the boxes themselves, so that coordinates of thousands of kilometres cost nothing.
  Polyhedron common = makeFaces(a, a.center_m);
  for (const HalfSpace& space : makeHalfSpaces(b, a.center_m)) {
    common = clip(common, space);
    if (common.empty()) return 0.0;
  }
  return computeVolume(common);
}

double computeIou(const RotatedBox& a, const RotatedBox& b) {
  const double common = computeIntersectionVolume(a, b);
  const double both = a.volume() + b.volume() - common;
  return both > 0.0 && common > 0.0 ? std::min(1.0, common / both) : 0.0;
}

}  // namespace tsg
