// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/world_mesh.h"

#include <cmath>
#include <vector>

namespace tsg::simulation {
namespace {

constexpr std::uint32_t kSides = 24;

/// A ring of corners about the z axis, in units of the half sizes.
struct Ring {
  double radius = 1.0;
  double z = 0.0;
};

/// The outline of a body from its lowest point up; a box's has four sides, its rings lie on
/// corners.
std::vector<Ring> findRings(const Solid& solid) {
  if (solid.shape == Shape::kBox)
    return {{0.0, -1.0}, {std::sqrt(2.0), -1.0}, {std::sqrt(2.0), 1.0}, {0.0, 1.0}};
  if (solid.shape == Shape::kFrustum) {
    return {{0.0, -1.0}, {1.0, -1.0}, {solid.top_ratio, 1.0}, {0.0, 1.0}};
  }
  std::vector<Ring> rings;
  constexpr std::uint32_t kSteps = kSides / 2;
  for (std::uint32_t i = 0; i <= kSteps; ++i) {
    const double angle = kPi * i / kSteps;
    rings.push_back({std::sin(angle), -std::cos(angle)});
  }
  return rings;
}

void addSolid(const Solid& solid, Mesh& mesh) {
  const bool is_box = solid.shape == Shape::kBox;
  const std::uint32_t sides = is_box ? 4 : kSides;
  const double first = is_box ? kPi / 4.0 : 0.0;
  const std::vector<Ring> rings = findRings(solid);
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Ring& ring : rings) {
    for (std::uint32_t i = 0; i < sides; ++i) {
      const double angle = first + 2.0 * kPi * i / sides;
      const Eigen::Vector3d unit(ring.radius * std::cos(angle), ring.radius * std::sin(angle),
                                 ring.z);
      const Eigen::Vector3d p_m = solid.T_world_solid * unit.cwiseProduct(solid.half_size_m);
      mesh.vertices.push_back(p_m.cast<float>());
      mesh.colors.push_back({128, 128, 128});
    }
  }
  for (std::uint32_t r = 0; r + 1 < rings.size(); ++r) {
    for (std::uint32_t i = 0; i < sides; ++i) {
      const std::uint32_t low = base + r * sides;
      const std::uint32_t next = (i + 1) % sides;
      mesh.triangles.push_back({low + i, low + next, low + sides + next});
      mesh.triangles.push_back({low + i, low + sides + next, low + sides + i});
    }
  }
}

}  // namespace

Mesh computeMesh(const Apartment& world) {
  Mesh mesh;
  for (const Solid& solid : world.solids) addSolid(solid, mesh);
  return mesh;
}

}  // namespace tsg::simulation
