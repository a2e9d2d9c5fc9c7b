// SPDX-License-Identifier: BSD-3-Clause
#include "point_cloud.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace tsg::evaluation {
namespace {

constexpr std::size_t kSmallestCluster = 5;
constexpr int kNoise = -1;

}  // namespace

std::size_t PointGrid::Hash::operator()(const Cell& cell) const {
  std::uint64_t hash = 0;
  for (const int value : cell) {
    hash = hash * 0x9e3779b97f4a7c15ULL + static_cast<std::uint32_t>(value);
  }
  return static_cast<std::size_t>(hash ^ (hash >> 29U));
}

PointGrid::Cell PointGrid::findCell(const Eigen::Vector3f& p_m) const {
  const Eigen::Vector3i cell = (p_m / cell_m_).array().floor().cast<int>();
  return {cell.x(), cell.y(), cell.z()};
}

PointGrid::PointGrid(const PointCloud& points_m, double cell_m)
    : points_m_(points_m), cell_m_(static_cast<float>(cell_m)) {
  for (std::size_t i = 0; i < points_m.size(); ++i) cells_[findCell(points_m[i])].push_back(i);
}

PointCloud downsample(const PointCloud& points_m, double voxel_m) {
  struct Sum {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
  };
  std::map<std::array<int, 3>, Sum> voxels;
  for (const Eigen::Vector3f& p : points_m) {
    const Eigen::Vector3i voxel = (p.cast<double>() / voxel_m).array().floor().cast<int>();
    Sum& sum = voxels[{voxel.x(), voxel.y(), voxel.z()}];
    sum.sum += p.cast<double>();
    ++sum.count;
  }
  PointCloud means_m;
  for (const auto& [voxel, sum] : voxels) {
    means_m.emplace_back((sum.sum / sum.count).cast<float>());
  }
  return means_m;
}

double computeOverlap(const PointCloud& a, const PointCloud& b, double distance_m) {
  if (a.empty() || b.empty()) return 0.0;
  const PointGrid grid(b, distance_m);
  std::size_t near = 0;
  for (const Eigen::Vector3f& p : a) {
    grid.forEachNear(p, [&](std::size_t) {
      ++near;
      return false;
    });
  }
  return static_cast<double>(near) / static_cast<double>(a.size());
}

PointCloud keepLargestCluster(const PointCloud& points_m, double radius_m, std::size_t min_points) {
  const PointGrid grid(points_m, radius_m);
  const auto findNear = [&](std::size_t i) {
    std::vector<std::size_t> near;
    grid.forEachNear(points_m[i], [&](std::size_t other) {
      near.push_back(other);
      return true;
    });
    return near;
  };
  std::vector<int> label_of(points_m.size(), kNoise);
  std::vector<std::size_t> sizes;
  for (std::size_t seed = 0; seed < points_m.size(); ++seed) {
    if (label_of[seed] != kNoise || findNear(seed).size() < min_points) continue;
    const int label = static_cast<int>(sizes.size());
    sizes.push_back(1);
    label_of[seed] = label;
    std::vector<std::size_t> open{seed};
    while (!open.empty()) {
      const auto near = findNear(open.back());
      open.pop_back();
      if (near.size() < min_points) continue;  // at the border: reached, but leads nowhere
      for (const std::size_t other : near) {
        if (label_of[other] != kNoise) continue;
        label_of[other] = label;
        ++sizes.back();
        open.push_back(other);
      }
    }
  }
  const auto largest = std::max_element(sizes.begin(), sizes.end());
  if (largest == sizes.end() || *largest < kSmallestCluster) return points_m;
  const int kept = static_cast<int>(largest - sizes.begin());
  PointCloud cluster_m;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (label_of[i] == kept) cluster_m.push_back(points_m[i]);
  }
  return cluster_m;
}

}  // namespace tsg::evaluation
