// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/marching_cubes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "synthetic_scene.h"
#include "task_scene_graph/mapping/marching_cubes_table.h"
#include "task_scene_graph/mapping/tsdf_integrator.h"

namespace tsg::mapping {
namespace {

using DirectedEdge = std::pair<std::uint32_t, std::uint32_t>;

/// Every directed edge occurs as often as its reverse: the surface has no border.
bool isClosed(const Mesh& mesh) {
  std::map<DirectedEdge, int> balance;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      ++balance[{t[i], t[(i + 1) % 3]}];
      --balance[{t[(i + 1) % 3], t[i]}];
    }
  }
  return std::all_of(balance.begin(), balance.end(), [](const auto& e) { return e.second == 0; });
}

/// Positive if triangles are counter-clockwise seen from outside.
double computeSignedVolume(const Mesh& mesh) {
  double volume = 0.0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>();
    volume += a.dot(mesh.vertices[t[1]].cast<double>().cross(mesh.vertices[t[2]].cast<double>()));
  }
  return volume / 6.0;
}

using Field = std::function<double(const Eigen::Vector3d&)>;

/// Blocks from `first` to `last`, every voxel known.
TsdfVolume makeVolume(double voxel_size_m, const GridIndex& first, const GridIndex& last,
                      const Field& field) {
  TsdfVolume volume(voxel_size_m);
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        TsdfBlock& block = volume.allocateBlock({x, y, z});
        for (int i = 0; i < kBlockVoxels; ++i) {
          const GridIndex voxel = block.index * kBlockSide + GridIndex(i & 7, i >> 3 & 7, i >> 6);
          auto& entry = block.voxels[static_cast<std::size_t>(i)];
          entry.distance_m = static_cast<float>(field(volume.computeVoxelCenter(voxel)));
          entry.weight = 1.0F;
          block.colors[static_cast<std::size_t>(i)] = {10, 20, 30, 255};
        }
      }
    }
  }
  return volume;
}

TsdfVolume makeSphereVolume(double radius_m) {
  return makeVolume(0.05, GridIndex::Constant(-2), GridIndex::Constant(1),
                    [=](const Eigen::Vector3d& p) { return p.norm() - radius_m; });
}

TEST(CellTable, TrianglesUseExactlyTheEdgesThatTheSurfaceCuts) {
  for (unsigned inside = 0; inside < 256; ++inside) {
    std::set<int> used;
    for (const auto& triangle : cellTriangles()[inside])
      used.insert(triangle.begin(), triangle.end());
    std::set<int> cut;
    for (int e = 0; e < kCellEdges; ++e) {
      const auto& edge = cellEdges()[static_cast<std::size_t>(e)];
      if ((inside >> edge.from & 1U) != (inside >> edge.to & 1U)) cut.insert(e);
    }
    EXPECT_EQ(used, cut) << "case " << inside;
  }
}

TEST(CellTable, SingleCornerGivesOneTriangleAndAHalfCellTwo) {
  for (unsigned corner = 0; corner < 8; ++corner) {
    EXPECT_EQ(cellTriangles()[1U << corner].size(), 1U);
    EXPECT_EQ(cellTriangles()[255U ^ (1U << corner)].size(), 1U);
  }
  EXPECT_EQ(cellTriangles()[0b00001111].size(), 2U);
  EXPECT_TRUE(cellTriangles()[0].empty());
  EXPECT_TRUE(cellTriangles()[255].empty());
}

TEST(MarchingCubes, RandomSignsGiveAClosedSurfaceAcrossBlocks) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> value(-1.0, 1.0);
    // Free space all round, so that the surface has nowhere to be open.
    const auto field = [&](const Eigen::Vector3d& p) {
      const bool is_border = (p.array() < -0.7).any() || (p.array() > 0.7).any();
      return is_border ? 1.0 : value(random);
    };
    const auto volume = makeVolume(0.1, GridIndex::Constant(-1), GridIndex::Constant(0), field);
    const Mesh mesh = computeMesh(volume, 0.0);
    EXPECT_GT(mesh.triangles.size(), 1000U);
    EXPECT_TRUE(isClosed(mesh)) << "seed " << seed;
    EXPECT_GT(computeSignedVolume(mesh), 0.0);
  }
}

TEST(MarchingCubes, SphereHasTheRightRadiusVolumeAndOrientation) {
  const double radius_m = 0.5;
  const Mesh mesh = computeMesh(makeSphereVolume(radius_m), 0.0);
  EXPECT_TRUE(isClosed(mesh));
  double squares = 0.0;
  for (const auto& vertex : mesh.vertices) {
    squares += std::pow(static_cast<double>(vertex.norm()) - radius_m, 2);
  }
  EXPECT_LE(std::sqrt(squares / static_cast<double>(mesh.vertices.size())), 0.05 * 0.05);
  const double sphere_m3 = 4.0 / 3.0 * M_PI * std::pow(radius_m, 3);
  EXPECT_NEAR(computeSignedVolume(mesh), sphere_m3, 0.01 * sphere_m3);
  for (const auto& color : mesh.colors) {
    EXPECT_EQ(color, (std::array<std::uint8_t, 3>{10, 20, 30}));
  }
}

TEST(MarchingCubes, PlaneThroughAnyDirectionIsExact) {
  std::mt19937 random(5);
  std::normal_distribution<double> gauss;
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector3d normal =
        Eigen::Vector3d(gauss(random), gauss(random), gauss(random)).normalized();
    const auto volume = makeVolume(0.05, GridIndex::Constant(-1), GridIndex::Constant(0),
                                   [&](const Eigen::Vector3d& p) { return normal.dot(p) - 0.013; });
    const Mesh mesh = computeMesh(volume, 0.0);
    ASSERT_FALSE(mesh.isEmpty());
    for (const auto& v : mesh.vertices) EXPECT_NEAR(normal.dot(v.cast<double>()), 0.013, 1e-6);
    for (const auto& t : mesh.triangles) {
      const Eigen::Vector3f a = mesh.vertices[t[1]] - mesh.vertices[t[0]];
      const Eigen::Vector3f b = mesh.vertices[t[2]] - mesh.vertices[t[0]];
      EXPECT_GT(normal.dot(a.cross(b).cast<double>()), -1e-9);
    }
  }
}

TEST(MarchingCubes, NoVertexOccursTwiceInABlock) {
  const auto volume = makeSphereVolume(0.47);
  std::size_t meshed = 0;
  for (const auto& index : volume.sortedBlockIndices()) {
    const Mesh mesh = computeBlockMesh(volume, index, 0.0);
    std::set<std::array<float, 3>> positions;
    for (const auto& v : mesh.vertices) positions.insert({v.x(), v.y(), v.z()});
    EXPECT_EQ(positions.size(), mesh.vertices.size());
    EXPECT_EQ(mesh.colors.size(), mesh.vertices.size());
    meshed += mesh.isEmpty() ? 0 : 1;
  }
  EXPECT_GT(meshed, 8U);
}

TEST(MarchingCubes, CellsWithAVoxelBelowTheWeightGiveNothing) {
  auto volume = makeSphereVolume(0.5);
  const Mesh all = computeMesh(volume, 0.5);
  EXPECT_TRUE(computeMesh(volume, 1.0).isEmpty());
  TsdfBlock* block = volume.findBlock({0, 0, 0});
  for (auto& voxel : block->voxels) voxel.weight = 0.5F;
  const Mesh part = computeMesh(volume, 0.5);
  EXPECT_LT(part.triangles.size(), all.triangles.size());
  EXPECT_FALSE(isClosed(part));
  // The block's voxel centres span 0.025 m to 0.375 m.
  for (const auto& v : part.vertices) EXPECT_TRUE(v.minCoeff() < 0.026F || v.maxCoeff() > 0.374F);
}

TEST(MarchingCubes, VoxelsWithoutColorTakeNoPartInColors) {
  auto volume = makeVolume(0.05, GridIndex::Zero(), GridIndex::Zero(),
                           [](const Eigen::Vector3d& p) { return p.z() - 0.2; });
  TsdfBlock* block = volume.findBlock({0, 0, 0});
  for (int i = 0; i < kBlockVoxels; ++i) {
    const auto voxel = static_cast<std::size_t>(i);
    if (block->voxels[voxel].distance_m > 0.0F) block->colors[voxel] = {};
  }
  const Mesh mesh = computeMesh(volume, 0.0);
  ASSERT_FALSE(mesh.isEmpty());
  for (const auto& color : mesh.colors) {
    EXPECT_EQ(color, (std::array<std::uint8_t, 3>{10, 20, 30}));
  }
}

TEST(MarchingCubes, ThreadCountDoesNotChangeTheMesh) {
  const auto volume = makeSphereVolume(0.6);
  const Mesh one = computeMesh(volume, 0.0, 1);
  const Mesh five = computeMesh(volume, 0.0, 5);
  EXPECT_EQ(one.vertices, five.vertices);
  EXPECT_EQ(one.triangles, five.triangles);
}

TEST(WeldVertices, KeepsTheSurfaceAndDropsWhatLostItsArea) {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {-0.0F, 0, 0}};
  mesh.colors.resize(mesh.vertices.size());
  mesh.triangles = {{0, 1, 2}, {4, 3, 5}, {0, 6, 1}};
  const Mesh welded = weldVertices(mesh);
  EXPECT_EQ(welded.vertices.size(), 4U);
  ASSERT_EQ(welded.triangles.size(), 2U);
  EXPECT_EQ(welded.triangles[1], (std::array<std::uint32_t, 3>{2, 1, 3}));
}

/// A box on a floor, seen from all round.
class SeenScene : public ::testing::Test {
 protected:
  SeenScene() : volume_(config_.voxel_size_m) {
    TsdfIntegrator integrator(config_);
    for (int i = 0; i < 12; ++i) {
      const double angle = i * M_PI / 6.0;
      const Eigen::Vector3d eye(1.8 * std::cos(angle), 1.8 * std::sin(angle), 1.4);
      views_.push_back(test::render(scene_, camera_, test::lookAt(eye, {0, 0, 0.3})).frame);
      integrator.integrate(views_.back(), volume_);
    }
    mesh_ = computeMesh(volume_, 1e-4);
  }

  double computeDistanceToMesh(const Eigen::Vector3d& p) const {
    double nearest = 1e9;
    for (const auto& v : mesh_.vertices) nearest = std::min(nearest, (v.cast<double>() - p).norm());
    return nearest;
  }

  const std::vector<test::Solid> scene_{
      test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90}),
      test::makeBox({Eigen::Vector3d(-0.4, -0.3, 0), Eigen::Vector3d(0.4, 0.3, 0.6)},
                    {200, 40, 20})};
  const CameraModel camera_{320, 240, 262.0, 262.0, 159.5, 119.5};
  IntegratorConfig config_;
  TsdfVolume volume_;
  std::vector<RgbdFrame> views_;
  Mesh mesh_;
};

TEST_F(SeenScene, VerticesLieOnTheSurfaceWithinHalfAVoxelRms) {
  double squares = 0.0;
  for (const auto& v : mesh_.vertices) {
    squares += std::pow(test::computeSceneDistance(scene_, v.cast<double>()), 2);
  }
  const double rms_m = std::sqrt(squares / static_cast<double>(mesh_.vertices.size()));
  EXPECT_LE(rms_m, 0.5 * config_.voxel_size_m);
}

TEST_F(SeenScene, TheFloorIsNotBiasedBySlantedViews) {
  double sum = 0.0;
  int count = 0;
  for (const auto& v : mesh_.vertices) {
    const bool is_floor = v.head<2>().cwiseAbs().maxCoeff() > 0.6F && std::abs(v.z()) < 0.05F;
    if (!is_floor) continue;
    sum += static_cast<double>(v.z());
    ++count;
  }
  ASSERT_GT(count, 500);
  EXPECT_LE(std::abs(sum / count), 0.02 * config_.voxel_size_m);
}

/// A floor seen from many places, always at about the same angle to its normal.
class GrazingViews : public testing::TestWithParam<double> {};

TEST_P(GrazingViews, DoNotBiasThePlane) {
  const double angle_rad = GetParam() * M_PI / 180.0;
  const std::vector<test::Solid> floor{test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90})};
  const CameraModel narrow{160, 120, 600.0, 600.0, 79.5, 59.5};  // 15 by 11 degrees
  IntegratorConfig config;
  TsdfIntegrator integrator(config);
  TsdfVolume volume(config.voxel_size_m);
  for (int i = 0; i < 40; ++i) {
    const double turn_rad = 0.7 * i;
    const Eigen::Vector3d target(0.02 * i, 0.013 * i, 0.0);
    const Eigen::Vector3d from_target(std::sin(angle_rad) * std::cos(turn_rad),
                                      std::sin(angle_rad) * std::sin(turn_rad),
                                      std::cos(angle_rad));
    integrator.integrate(
        test::render(floor, narrow, test::lookAt(target + 3.0 * from_target, target)).frame,
        volume);
  }
  const Mesh mesh = computeMesh(volume, 1e-4);
  ASSERT_GT(mesh.vertices.size(), 50U);
  double sum_m = 0.0;
  double squares_m2 = 0.0;
  for (const auto& v : mesh.vertices) {
    sum_m += static_cast<double>(v.z());
    squares_m2 += std::pow(static_cast<double>(v.z()), 2);
  }
  const auto count = static_cast<double>(mesh.vertices.size());
  EXPECT_LE(std::abs(sum_m / count), 0.1 * config.voxel_size_m);
  EXPECT_LE(std::sqrt(squares_m2 / count), 0.5 * config.voxel_size_m);
}

INSTANTIATE_TEST_SUITE_P(Degrees, GrazingViews, testing::Values(0.0, 60.0, 75.0, 80.0));

TEST_F(SeenScene, SeenSurfacesHaveNoHoles) {
  // Points of the depth images, away from the rim of what was seen.
  int count = 0;
  for (std::size_t k = 0; k < views_.size(); k += 4) {
    const auto& frame = views_[k];
    for (int v = 40; v < 200; v += 13) {
      for (int u = 40; u < 280; u += 13) {
        const double z_m = frame.depth.at(u, v);
        if (z_m < config_.min_range_m || z_m > 3.0) continue;
        const Eigen::Vector3d p = frame.T_world_camera * camera_.unproject(u, v, z_m);
        EXPECT_LE(computeDistanceToMesh(p), 1.5 * config_.voxel_size_m) << p.transpose();
        ++count;
      }
    }
  }
  EXPECT_GT(count, 300);
}

TEST_F(SeenScene, ColorsAreThoseOfTheSurfaces) {
  int red = 0;
  int gray = 0;
  for (std::size_t i = 0; i < mesh_.vertices.size(); ++i) {
    const auto& p = mesh_.vertices[i];
    const auto& color = mesh_.colors[i];
    if (p.z() > 0.55F && p.head<2>().cwiseAbs().maxCoeff() < 0.2F) {
      EXPECT_NEAR(color[0], 200, 2);
      EXPECT_NEAR(color[2], 20, 2);
      ++red;
    } else if (p.head<2>().cwiseAbs().maxCoeff() > 0.8F) {
      EXPECT_NEAR(color[0], 90, 2);
      ++gray;
    }
  }
  EXPECT_GT(red, 20);
  EXPECT_GT(gray, 200);
}

}  // namespace
}  // namespace tsg::mapping
