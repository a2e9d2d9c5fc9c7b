// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/vertex_labels.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::mapping {
namespace {

using Eigen::Vector3f;

struct Triangle {
  Vector3f a, b, c;
};

float squaredDistanceToSegment(const Vector3f& p, const Vector3f& a, const Vector3f& b) {
  const Vector3f along = b - a;
  const float length2 = along.squaredNorm();
  const float t = length2 > 0.0F ? std::clamp((p - a).dot(along) / length2, 0.0F, 1.0F) : 0.0F;
  return (p - a - t * along).squaredNorm();
}

float squaredDistance(const Vector3f& p, const Triangle& t) {
  const Vector3f normal = (t.b - t.a).cross(t.c - t.a);
  const float area2 = normal.squaredNorm();
  const auto isInside = [&](const Vector3f& from, const Vector3f& to) {
    return normal.dot((to - from).cross(p - from)) >= 0.0F;
  };
  if (area2 > 0.0F && isInside(t.a, t.b) && isInside(t.b, t.c) && isInside(t.c, t.a)) {
    const float height = normal.dot(p - t.a);
    return height * height / area2;
  }
  return std::min({squaredDistanceToSegment(p, t.a, t.b), squaredDistanceToSegment(p, t.b, t.c),
                   squaredDistanceToSegment(p, t.c, t.a)});
}

/// Vertices of a mesh by cells of space; remembers the nearest label of each.
class VertexGrid {
 public:
  VertexGrid(const Mesh& mesh, float cell_m)
      : mesh_(mesh),
        cell_m_(cell_m),
        labels_(mesh.vertices.size(), 0),
        squared_m2_(mesh.vertices.size(), std::numeric_limits<float>::infinity()) {
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      cells_[computeCell(mesh.vertices[i])].push_back(i);
    }
  }

  /// Labels vertices within one cell's size of the triangle that have no nearer one.
  void label(const Triangle& triangle, std::int32_t label) {
    const Vector3f margin = Vector3f::Constant(cell_m_);
    const GridIndex low =
        computeCell(triangle.a.cwiseMin(triangle.b).cwiseMin(triangle.c) - margin);
    const GridIndex high =
        computeCell(triangle.a.cwiseMax(triangle.b).cwiseMax(triangle.c) + margin);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) labelCell({x, y, z}, triangle, label);
      }
    }
  }
  std::vector<std::int32_t> takeLabels() { return std::move(labels_); }

 private:
  GridIndex computeCell(const Vector3f& p) const {
    return (p.array() / cell_m_).floor().cast<int>().matrix();
  }

  void labelCell(const GridIndex& cell, const Triangle& triangle, std::int32_t label) {
    const auto found = cells_.find(cell);
    if (found == cells_.end()) return;
    for (const std::size_t i : found->second) {
      const float squared_m2 = squaredDistance(mesh_.vertices[i], triangle);
      if (squared_m2 > cell_m_ * cell_m_ || squared_m2 > squared_m2_[i]) continue;
      if (squared_m2 == squared_m2_[i] && labels_[i] <= label) continue;
      squared_m2_[i] = squared_m2;
      labels_[i] = label;
    }
  }

  const Mesh& mesh_;
  float cell_m_;
  std::vector<std::int32_t> labels_;
  std::vector<float> squared_m2_;  ///< to the surface of that label
  std::unordered_map<GridIndex, std::vector<std::size_t>, GridIndexHash> cells_;
};

}  // namespace

std::vector<std::int32_t> labelVertices(const Mesh& mesh, const std::vector<LabelledMesh>& objects,
                                        double max_distance_m) {
  if (!(max_distance_m > 0.0)) {
    throw std::invalid_argument("labels of vertices: max_distance_m is " +
                                std::to_string(max_distance_m) + ", expected more than 0");
  }
  VertexGrid grid(mesh, static_cast<float>(max_distance_m));
  for (const auto& object : objects) {
    const auto& vertices = object.mesh->vertices;
    for (const auto& t : object.mesh->triangles) {
      grid.label({vertices[t[0]], vertices[t[1]], vertices[t[2]]}, object.label);
    }
  }
  return grid.takeLabels();
}

std::vector<std::int32_t> labelVertices(
    const Mesh& mesh, const std::vector<ObjectPrimitivePtr>& primitives,
    const std::map<PrimitiveId, std::int32_t>& label_of_primitive, double max_distance_m) {
  std::vector<LabelledMesh> objects;
  for (const auto& primitive : primitives) {
    const auto label = label_of_primitive.find(primitive->id);
    if (label != label_of_primitive.end()) objects.push_back({&primitive->mesh, label->second});
  }
  return labelVertices(mesh, objects, max_distance_m);
}

}  // namespace tsg::mapping
