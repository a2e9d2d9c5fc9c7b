// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/mesh_scores.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace tsg::evaluation {
namespace {

using Eigen::Vector3f;

void addTriangle(Mesh& mesh, const Vector3f& a, const Vector3f& b, const Vector3f& c) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
  mesh.triangles.push_back({first, first + 1, first + 2});
}

/// A floor of 10 m x 10 m at height 0.
Mesh makeFloor() {
  Mesh mesh;
  addTriangle(mesh, {0, 0, 0}, {10, 0, 0}, {10, 10, 0});
  addTriangle(mesh, {0, 0, 0}, {10, 10, 0}, {0, 10, 0});
  return mesh;
}

Mesh makePoints(const std::vector<Vector3f>& points) {
  Mesh mesh;
  mesh.vertices = points;
  return mesh;
}

/// By barycentric coordinates on a fine grid.
double searchDistance(const Mesh& mesh, const Vector3f& p_m) {
  constexpr int kSteps = 200;
  double best_m = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const float u = static_cast<float>(i) / kSteps;
        const float v = static_cast<float>(j) / kSteps;
        const Vector3f q_m =
            (1 - u - v) * mesh.vertices[t[0]] + u * mesh.vertices[t[1]] + v * mesh.vertices[t[2]];
        best_m = std::min(best_m, static_cast<double>((q_m - p_m).norm()));
      }
    }
  }
  return best_m;
}

TEST(MeshScores, AreDistancesToTheTrueSurface) {
  const Mesh mesh = makePoints({{5, 5, 0}, {2, 7, 0.04F}, {1, 1, -0.1F}, {5, 5, 0.3F}});
  const MeshScores scores = computeMeshScores(mesh, makeFloor());
  EXPECT_EQ(scores.num_vertices, 4u);
  EXPECT_NEAR(scores.mean_m, 0.11, 1e-6);
  EXPECT_NEAR(scores.rms_m, std::sqrt((0.0016 + 0.01 + 0.09) / 4.0), 1e-6);
  EXPECT_EQ(scores.right, 0.5);
}

TEST(MeshScores, FarVerticesCountAsTheLargestDistance) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Mesh mesh = makePoints({{5, 5, 3}, {-100, 5, 0}, {nan, 0, 0}, {3e8F, 0, 0}});
  const MeshScores scores = computeMeshScores(mesh, makeFloor());
  EXPECT_EQ(scores.mean_m, 0.5);
  EXPECT_EQ(scores.percentile95_m, 0.5);
  EXPECT_EQ(scores.right, 0.0);
}

TEST(MeshScores, PercentileLeavesTheWorstOut) {
  Mesh mesh;
  for (int i = 0; i < 100; ++i) mesh.vertices.emplace_back(5.0F, 5.0F, i < 96 ? 0.01F : 0.4F);
  EXPECT_NEAR(computeMeshScores(mesh, makeFloor()).percentile95_m, 0.01, 1e-6);
}

TEST(MeshScores, AgreeWithASearchOverRandomTriangles) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  const auto makePoint = [&] {
    return Vector3f(uniform(random), uniform(random), uniform(random));
  };
  for (int round = 0; round < 20; ++round) {
    Mesh truth;
    const float scale = round % 2 == 0 ? 0.1F : 3.0F;  // within a cell, over many cells
    for (int i = 0; i < 3; ++i) {
      const Vector3f corner = makePoint();
      addTriangle(truth, corner, corner + scale * makePoint(), corner + scale * makePoint());
    }
    const Vector3f p_m = makePoint();
    MeshScoresConfig config;
    config.max_distance_m = 10.0;
    const double found_m = computeMeshScores(makePoints({p_m}), truth, config).mean_m;
    const double expected_m = searchDistance(truth, p_m);
    EXPECT_LE(found_m, expected_m + 1e-5) << round;
    EXPECT_GE(found_m, expected_m - 0.02 * scale) << round;
  }
}

TEST(MeshScores, DegenerateTrianglesArePoints) {
  Mesh truth;
  addTriangle(truth, {1, 1, 1}, {1, 1, 1}, {1, 1, 1});
  EXPECT_NEAR(computeMeshScores(makePoints({{1, 1, 1.2F}}), truth).mean_m, 0.2, 1e-6);
}

TEST(MeshScores, RefuseWhatHasNoSurface) {
  EXPECT_THROW(computeMeshScores({}, makeFloor()), std::invalid_argument);
  EXPECT_THROW(computeMeshScores(makePoints({{0, 0, 0}}), {}), std::invalid_argument);
  Mesh broken = makeFloor();
  broken.vertices[4].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(computeMeshScores(makePoints({{0, 0, 0}}), broken), std::invalid_argument);
}

}  // namespace
}  // namespace tsg::evaluation
