// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/mesh_scores.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::evaluation {
namespace {

using Eigen::Vector3d;
using mapping::GridIndex;
using mapping::GridIndexHash;
using Triangle = std::array<Vector3d, 3>;

constexpr double kCell_m = 0.25;
constexpr double kFarthest_m = 1e6;
constexpr std::size_t kMaxTriangles = 4'000'000;

/// [Ericson05, Sec. 5.1.5]: the region of the triangle's plane over which the point lies says which
/// corner, side or inner point is the nearest.
Vector3d findNearestPoint(const Triangle& triangle, const Vector3d& p_m) {
  const auto& [a, b, c] = triangle;
  const Vector3d ab = b - a;
  const Vector3d ac = c - a;
  const double d1 = ab.dot(p_m - a);
  const double d2 = ac.dot(p_m - a);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const double d3 = ab.dot(p_m - b);
  const double d4 = ac.dot(p_m - b);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  const double d5 = ab.dot(p_m - c);
  const double d6 = ac.dot(p_m - c);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) {
    return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  }
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

bool isUsable(const Vector3d& p_m) {
  return p_m.allFinite() && p_m.cwiseAbs().maxCoeff() <= kFarthest_m;
}

GridIndex toCell(const Vector3d& p_m) { return (p_m / kCell_m).array().floor().cast<int>(); }

/// Calls visit for each cell of a box.
template <typename Visit>
void forEachCell(const GridIndex& low, const GridIndex& high, const Visit& visit) {
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) visit(GridIndex(x, y, z));
    }
  }
}

/// True triangles by the cells that they may touch.
class Surfaces {
 public:
  explicit Surfaces(const Mesh& mesh) {
    for (const auto& corners : mesh.triangles) {
      Triangle triangle;
      for (std::size_t i = 0; i < 3; ++i) {
        triangle[i] = mesh.vertices.at(corners[i]).cast<double>();
        if (isUsable(triangle[i])) continue;
        throw std::invalid_argument(
            "the true mesh has a vertex that is not finite or beyond 1e6 m");
      }
      add(triangle);
    }
  }

  /// At most `max_m`.
  double computeDistance(const Vector3d& p_m, double max_m) const {
    double best = max_m;
    const GridIndex centre = toCell(p_m);
    const int last_ring = static_cast<int>(std::ceil(max_m / kCell_m));
    for (int ring = 0; ring <= last_ring && (ring - 1) * kCell_m < best; ++ring) {
      forEachCell(centre - GridIndex::Constant(ring), centre + GridIndex::Constant(ring),
                  [&](const GridIndex& cell) {
                    if ((cell - centre).cwiseAbs().maxCoeff() == ring) search(cell, p_m, best);
                  });
    }
    return best;
  }

 private:
  /// Large triangles are halved until they are not much larger than cells, or a slanted one would
  /// be in all cells of its box.
  void add(const Triangle& triangle) {
    constexpr double kMaxSide_m = 4.0 * kCell_m;
    std::size_t longest = 0;
    double length_m = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double side_m = (triangle[(i + 1) % 3] - triangle[i]).norm();
      if (side_m > length_m) {
        length_m = side_m;
        longest = i;
      }
    }
    if (length_m <= kMaxSide_m) {
      list(triangle);
      return;
    }
    const Vector3d& from = triangle[longest];
    const Vector3d& to = triangle[(longest + 1) % 3];
    const Vector3d& other = triangle[(longest + 2) % 3];
    const Vector3d middle = (from + to) / 2.0;
    add({from, middle, other});
    add({middle, to, other});
  }

  void list(const Triangle& triangle) {
    if (triangles_.size() >= kMaxTriangles) {
      throw std::invalid_argument("the true mesh has more surface than 4 million triangles of " +
                                  std::to_string(4.0 * kCell_m) + " m cover");
    }
    const auto& [a, b, c] = triangle;
    const auto index = static_cast<std::uint32_t>(triangles_.size());
    triangles_.push_back(triangle);
    forEachCell(toCell(a.cwiseMin(b).cwiseMin(c)), toCell(a.cwiseMax(b).cwiseMax(c)),
                [&](const GridIndex& cell) { cells_[cell].push_back(index); });
  }

  void search(const GridIndex& cell, const Vector3d& p_m, double& best_m) const {
    const auto found = cells_.find(cell);
    if (found == cells_.end()) return;
    for (const std::uint32_t index : found->second) {
      best_m = std::min(best_m, (findNearestPoint(triangles_[index], p_m) - p_m).norm());
    }
  }

  std::vector<Triangle> triangles_;
  std::unordered_map<GridIndex, std::vector<std::uint32_t>, GridIndexHash> cells_;
};

}  // namespace

MeshScores computeMeshScores(const Mesh& mesh, const Mesh& truth, const MeshScoresConfig& config) {
  if (mesh.vertices.empty() || truth.triangles.empty()) {
    throw std::invalid_argument(
        "the map's mesh has " + std::to_string(mesh.vertices.size()) + " vertices, the true one " +
        std::to_string(truth.triangles.size()) + " triangles; expected some of both");
  }
  const Surfaces surfaces(truth);
  std::vector<double> distances_m;
  distances_m.reserve(mesh.vertices.size());
  MeshScores scores;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    const Vector3d p_m = vertex.cast<double>();
    const double distance_m = isUsable(p_m) ? surfaces.computeDistance(p_m, config.max_distance_m)
                                            : config.max_distance_m;
    distances_m.push_back(distance_m);
    scores.mean_m += distance_m;
    scores.rms_m += distance_m * distance_m;
    scores.right += distance_m <= config.threshold_m ? 1.0 : 0.0;
  }
  scores.num_vertices = distances_m.size();
  const auto count = static_cast<double>(distances_m.size());
  scores.mean_m /= count;
  scores.rms_m = std::sqrt(scores.rms_m / count);
  scores.right /= count;
  const auto rank = static_cast<std::ptrdiff_t>(0.95 * (count - 1.0));
  std::nth_element(distances_m.begin(), distances_m.begin() + rank, distances_m.end());
  scores.percentile95_m = distances_m[static_cast<std::size_t>(rank)];
  return scores;
}

}  // namespace tsg::evaluation
