// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "task_scene_graph/places/sparse_graph.h"

namespace tsg::places {
namespace {

using CoarseIndex = std::pair<int, int>;

/// Places by coarse cell, to look up what is near.
class PlaceIndex {
 public:
  explicit PlaceIndex(double cell_size_m) : cell_size_m_(cell_size_m) {}

  CoarseIndex computeCoarse(const Eigen::Vector3d& p) const {
    return {static_cast<int>(std::floor(p.x() / cell_size_m_)),
            static_cast<int>(std::floor(p.y() / cell_size_m_))};
  }

  Eigen::Vector2d computeCenter(const CoarseIndex& coarse) const {
    return cell_size_m_ * Eigen::Vector2d(coarse.first + 0.5, coarse.second + 0.5);
  }

  void add(const Eigen::Vector3d& p) { positions_m_[computeCoarse(p)].push_back(p.head<2>()); }

  /// Precondition: distance_m <= the cell size.
  bool hasWithin(const Eigen::Vector3d& p, double distance_m) const {
    const auto [x, y] = computeCoarse(p);
    for (int i = 0; i < 9; ++i) {
      const auto found = positions_m_.find({x + i % 3 - 1, y + i / 3 - 1});
      if (found == positions_m_.end()) continue;
      for (const Eigen::Vector2d& other : found->second) {
        if ((other - p.head<2>()).norm() < distance_m) return true;
      }
    }
    return false;
  }

 private:
  double cell_size_m_;
  std::map<CoarseIndex, std::vector<Eigen::Vector2d>> positions_m_;
};

}  // namespace

std::vector<SparsePlace> findFillPlaces(const FreeSpace& space,
                                        const std::vector<SparsePlace>& places,
                                        const PlacesConfig& config) {
  const double spacing_m = std::min(config.fill_distance_m, config.cell_size_m);
  PlaceIndex index(config.cell_size_m);
  std::vector<char> is_place(space.is_free.size(), 0);
  for (const SparsePlace& place : places) is_place[place.cell] = 1;
  const NearestField nearest =
      computeNearestField(space.extent, is_place, spacing_m / space.voxel_size_m);
  std::map<CoarseIndex, std::tuple<double, std::size_t>> best;  // distance to the middle, cell
  for (std::size_t cell = 0; cell < space.is_free.size(); ++cell) {
    const auto clearance_m = static_cast<double>(space.clearance_m[cell]);
    if (space.is_free[cell] == 0 || clearance_m < config.min_clearance_m) continue;
    if (nearest.source[cell] != NearestField::kNone) continue;
    const Eigen::Vector3d p = space.computePosition(cell);
    const CoarseIndex coarse = index.computeCoarse(p);
    const double offset_m = (p.head<2>() - index.computeCenter(coarse)).norm();
    const auto [entry, is_new] = best.try_emplace(coarse, offset_m, cell);
    if (!is_new) entry->second = std::min(entry->second, {offset_m, cell});
  }
  std::vector<SparsePlace> added;
  for (const auto& [coarse, candidate] : best) {
    const std::size_t cell = std::get<1>(candidate);
    const SparsePlace place{cell, space.computePosition(cell),
                            static_cast<double>(space.clearance_m[cell])};
    if (index.hasWithin(place.position_m, spacing_m)) continue;
    index.add(place.position_m);
    added.push_back(place);
  }
  return added;
}

}  // namespace tsg::places
