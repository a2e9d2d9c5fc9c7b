// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/vertex_labels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace tsg::mapping {
namespace {

/// Two triangles at height z, from (x, 0) to (x + 1, 1).
Mesh makeSquare(float x, float z) {
  Mesh mesh;
  mesh.vertices = {{x, 0, z}, {x + 1, 0, z}, {x + 1, 1, z}, {x, 1, z}};
  mesh.colors.resize(4);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

Mesh makePoints(const std::vector<Eigen::Vector3f>& points) {
  Mesh mesh;
  mesh.vertices = points;
  mesh.colors.resize(points.size());
  return mesh;
}

TEST(VertexLabels, AVertexGetsTheObjectWhoseSurfaceIsNearest) {
  const Mesh low = makeSquare(0.0F, 0.0F);
  const Mesh high = makeSquare(0.0F, 0.3F);
  const Mesh points = makePoints({{0.5F, 0.4F, 0.1F},     // inside the low square, far from corners
                                  {0.5F, 0.4F, 0.16F},    // nearer to the high one
                                  {0.5F, 0.4F, -0.21F},   // too far
                                  {1.15F, 0.5F, 0.0F},    // beyond an edge
                                  {1.15F, 1.15F, 0.0F},   // beyond a corner: 0.212 away
                                  {0.5F, 0.5F, 0.15F}});  // half way
  EXPECT_EQ(labelVertices(points, {{&high, 9}, {&low, 4}}, 0.2),
            (std::vector<std::int32_t>{4, 9, 0, 4, 0, 4}));
}

TEST(VertexLabels, PrimitivesWithoutALabelAreBackground) {
  auto first = std::make_shared<ObjectPrimitive>();
  first->id = {1};
  first->mesh = makeSquare(0.0F, 0.0F);
  auto second = std::make_shared<ObjectPrimitive>();
  second->id = {2};
  second->mesh = makeSquare(2.0F, 0.0F);
  const Mesh points = makePoints({{0.5F, 0.5F, 0.0F}, {2.5F, 0.5F, 0.0F}});
  EXPECT_EQ(labelVertices(points, {first, second}, {{PrimitiveId{2}, 7}}, 0.1),
            (std::vector<std::int32_t>{0, 7}));
}

TEST(VertexLabels, DistanceMustBePositive) {
  EXPECT_THROW(labelVertices(Mesh{}, std::vector<LabelledMesh>{}, 0.0), std::invalid_argument);
}

/// Distance to a triangle by brute force over points of it.
float sampleDistance(const Eigen::Vector3f& p, const Mesh& mesh) {
  constexpr int kSteps = 60;
  float nearest_m = 1e9F;
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const float u = static_cast<float>(i) / kSteps;
        const float v = static_cast<float>(j) / kSteps;
        const Eigen::Vector3f q =
            (1 - u - v) * mesh.vertices[t[0]] + u * mesh.vertices[t[1]] + v * mesh.vertices[t[2]];
        nearest_m = std::min(nearest_m, (p - q).norm());
      }
    }
  }
  return nearest_m;
}

TEST(VertexLabels, AgreeWithBruteForceInRandomScenesWhateverTheOrder) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> number(-0.5F, 0.5F);
  const auto makePoint = [&] {
    return Eigen::Vector3f(number(engine), number(engine), number(engine));
  };
  constexpr float kRadius = 0.15F;
  constexpr float kSlack = 0.01F;  // of the samples
  int num_decided = 0;
  for (int round = 0; round < 10; ++round) {
    std::vector<Mesh> meshes(3);
    for (auto& mesh : meshes) {
      for (int i = 0; i < 6; ++i) mesh.vertices.push_back(makePoint());
      mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    }
    Mesh points;
    for (int i = 0; i < 60; ++i) points.vertices.push_back(makePoint());
    std::vector<LabelledMesh> objects{{&meshes[0], 5}, {&meshes[1], 2}, {&meshes[2], 8}};
    const auto labels = labelVertices(points, objects, kRadius);
    std::reverse(objects.begin(), objects.end());
    EXPECT_EQ(labelVertices(points, objects, kRadius), labels);
    for (std::size_t i = 0; i < labels.size(); ++i) {
      std::vector<std::pair<float, std::int32_t>> found{{kRadius, 0}};
      for (const auto& object : objects) {
        found.emplace_back(sampleDistance(points.vertices[i], *object.mesh), object.label);
      }
      std::sort(found.begin(), found.end());
      if (found[1].first - found[0].first < kSlack) continue;
      EXPECT_EQ(labels[i], found[0].second) << "round " << round << " point " << i;
      ++num_decided;
    }
  }
  EXPECT_GT(num_decided, 300);
}

}  // namespace
}  // namespace tsg::mapping
