// SPDX-License-Identifier: BSD-3-Clause
// The background mesh of the rendered house against the geometry that was rendered.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>
#include <unordered_map>

#include "sequence.h"
#include "support.h"
#include "task_scene_graph/mapping/background_map.h"

namespace tsg::mapping {
namespace {

constexpr double kVoxelSize_m = 0.05;

using Triangle = std::array<Eigen::Vector3d, 3>;

double computeDistanceToSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

double computeDistance(const Eigen::Vector3d& p, const Triangle& t) {
  const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
  bool is_above = normal.squaredNorm() > 0.0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d& a = t[i];
    const Eigen::Vector3d& b = t[(i + 1) % 3];
    is_above = is_above && normal.cross(b - a).dot(p - a) >= 0.0;
    nearest = std::min(nearest, computeDistanceToSegment(p, a, b));
  }
  return is_above ? std::abs(normal.dot(p - t[0])) / normal.norm() : nearest;
}

/// Distance to the nearest of many triangles, as long as it is below the cell size.
class TriangleGrid {
 public:
  static constexpr double kCell_m = 0.15;

  void add(const Triangle& triangle) {
    const auto id = static_cast<std::uint32_t>(triangles_.size());
    triangles_.push_back(triangle);
    const GridIndex low = cellOf(triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]));
    const GridIndex high = cellOf(triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]));
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          const Eigen::Vector3d center =
              (GridIndex(x, y, z).cast<double>().array() + 0.5) * kCell_m;
          // Large slanted triangles miss most cells of their box.
          if (computeDistance(center, triangle) < kCell_m) cells_[{x, y, z}].push_back(id);
        }
      }
    }
  }

  double computeNearest(const Eigen::Vector3d& p) const {
    double nearest = kCell_m;
    const GridIndex center = cellOf(p);
    for (int i = 0; i < 27; ++i) {
      const auto cell = cells_.find(center + GridIndex(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
      if (cell == cells_.end()) continue;
      for (const auto id : cell->second)
        nearest = std::min(nearest, computeDistance(p, triangles_[id]));
    }
    return nearest;
  }

 private:
  static GridIndex cellOf(const Eigen::Vector3d& p) {
    return (p / kCell_m).array().floor().cast<int>().matrix();
  }
  std::vector<Triangle> triangles_;
  std::unordered_map<GridIndex, std::vector<std::uint32_t>, GridIndexHash> cells_;
};

template <typename T>
T take(std::istream& stream) {
  T value{};
  stream.read(reinterpret_cast<char*>(&value), sizeof(T));
  return value;
}

/// Reads the PLY of the data set: float positions, faces with an instance id.
TriangleGrid loadTruth(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::size_t vertices = 0;
  std::size_t faces = 0;
  for (std::string line; std::getline(file, line) && line != "end_header";) {
    std::sscanf(line.c_str(), "element vertex %zu", &vertices);
    std::sscanf(line.c_str(), "element face %zu", &faces);
  }
  std::vector<Eigen::Vector3d> points(vertices);
  for (auto& p : points) {
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = static_cast<double>(take<float>(file));
    }
  }
  TriangleGrid grid;
  for (std::size_t i = 0; i < faces; ++i) {
    EXPECT_EQ(take<std::uint8_t>(file), 3);
    Triangle triangle;
    for (auto& corner : triangle) corner = points.at(take<std::uint32_t>(file));
    take<std::uint16_t>(file);  // instance_id
    grid.add(triangle);
  }
  EXPECT_TRUE(file);
  return grid;
}

double computeQuantile(std::vector<double>& values, double share) {
  const auto nth = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(nth), values.end());
  return values[nth];
}

TEST(HouseMesh, LiesOnTheTrueSurfaceAndCoversWhatWasSeen) {
  TSG_REQUIRE_SHARED(folder, "data/house_a");
  BackgroundConfig config;
  config.tsdf.voxel_size_m = kVoxelSize_m;
  config.archive_blocks = false;
  BackgroundMap map(config);
  std::vector<Eigen::Vector3d> seen;
  for (int i = 0; i < 100; i += 4) {
    const auto frame = test::loadSequenceFrame(folder, i);
    map.integrate(frame);
    for (int v = 7; v < 480; v += 41) {
      for (int u = 7; u < 640; u += 41) {
        const double z_m = frame.depth.at(u, v);
        if (z_m < config.tsdf.min_range_m || z_m > config.tsdf.max_range_m) continue;
        seen.push_back(frame.T_world_camera * frame.camera.unproject(u, v, z_m));
      }
    }
  }
  const Mesh mesh = map.extractMesh();
  const TriangleGrid truth = loadTruth(folder / "scene_mesh.ply");
  std::vector<double> errors_m;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    errors_m.push_back(truth.computeNearest(mesh.vertices[i].cast<double>()));
  }
  TriangleGrid ours;
  for (const auto& t : mesh.triangles) {
    ours.add({mesh.vertices[t[0]].cast<double>(), mesh.vertices[t[1]].cast<double>(),
              mesh.vertices[t[2]].cast<double>()});
  }
  std::vector<double> gaps_m;
  for (const auto& p : seen) gaps_m.push_back(ours.computeNearest(p));

  const double median = computeQuantile(errors_m, 0.5) / kVoxelSize_m;
  const double covered = computeQuantile(gaps_m, 0.95) / kVoxelSize_m;
  std::cout << "accuracy: median " << median << " voxel, 95 % within "
            << computeQuantile(errors_m, 0.95) / kVoxelSize_m << " voxel; completeness: median "
            << computeQuantile(gaps_m, 0.5) / kVoxelSize_m << ", 95 % within " << covered
            << " voxel (" << errors_m.size() << " vertices, " << gaps_m.size() << " seen points)\n";
  EXPECT_LE(median, 0.3);
  EXPECT_LE(covered, 1.5);
}

}  // namespace
}  // namespace tsg::mapping
