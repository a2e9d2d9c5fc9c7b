// SPDX-License-Identifier: BSD-3-Clause
#include "main_part.h"

#include <algorithm>
#include <cstdint>
#include <unordered_map>

namespace tsg::mapping {
namespace {

constexpr double kSmallestCell_m = 0.03;
constexpr int kMaxRounds = 3;

/// Cells by their coordinates, 21 bits each: points lie within a few metres of `origin_m`.
using CellKey = std::uint64_t;
constexpr CellKey kOffset = CellKey{1} << 20U;
constexpr CellKey kStepX = 1;
constexpr CellKey kStepY = CellKey{1} << 21U;
constexpr CellKey kStepZ = CellKey{1} << 42U;

class Grid {
 public:
  Grid(const Aabb& extent, double cell_m) : origin_m_(extent.min()), cells_per_m_(1.0 / cell_m) {}

  CellKey findCell(const Eigen::Vector3d& p_world) const {
    const Eigen::Vector3d cell = ((p_world - origin_m_) * cells_per_m_).array().floor();
    const auto toBits = [](double value) {
      return static_cast<CellKey>(static_cast<std::int64_t>(value)) + kOffset;
    };
    return toBits(cell.x()) * kStepX + toBits(cell.y()) * kStepY + toBits(cell.z()) * kStepZ;
  }

 private:
  Eigen::Vector3d origin_m_;
  double cells_per_m_;
};

struct CellRecord {
  std::size_t points = 0;
  int part = -1;
};
using Cells = std::unordered_map<CellKey, CellRecord>;

/// Calls `action(u, v, cell)` for the object's pixels with a usable depth, of every `step`th column
/// and row.
template <typename Action>
void forEachPoint(const ObjectConfig& config, const ObjectView& view, const Grid& grid, int step,
                  const Action& action) {
  const cv::Rect rect = findLabel(view.labels, view.segment);
  for (int v = rect.y; v < rect.y + rect.height; v += step) {
    const auto* labels = view.labels.ptr<std::uint16_t>(v);
    for (int u = rect.x; u < rect.x + rect.width; u += step) {
      if (labels[u] != view.segment) continue;
      const double z_m = view.frame.depth.at(u, v);
      if (z_m <= 0.0 || z_m < config.min_range_m || z_m > config.max_range_m) continue;
      action(u, v,
             grid.findCell(view.frame.T_world_camera * view.frame.camera.unproject(u, v, z_m)));
    }
  }
}

/// What a pixel covers, seen head-on, at the corner of `extent` that is farthest from the camera.
double computePixelSize(const ObjectView& view, const Aabb& extent) {
  double farthest_m = 0.0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner_m = extent.corner(static_cast<Aabb::CornerType>(i));
    farthest_m = std::max(farthest_m, (corner_m - view.frame.T_world_camera.translation()).norm());
  }
  return farthest_m / view.frame.camera.fx_px;
}

/// Wide enough that surface seen at a slant hangs together.
double findCellSize(const ObjectConfig& config, const Aabb& extent,
                    const std::vector<ObjectView>& views) {
  constexpr double kLeastPixels = 3.0;  // across a cell
  double cell_m =
      std::max(2.0 * config.resolution_fraction * extent.sizes().maxCoeff(), kSmallestCell_m);
  for (const ObjectView& view : views) {
    cell_m = std::max(cell_m, kLeastPixels * computePixelSize(view, extent));
  }
  return cell_m;
}

/// So many columns and rows that a cell seen head-on still has some pixels.
int findStep(const ObjectView& view, const Aabb& extent, double cell_m) {
  constexpr double kLeastPixels = 4.0;  // across a cell
  constexpr double kLargestStep = 4.0;
  const double pixels = cell_m / std::max(computePixelSize(view, extent), 1e-6);
  return static_cast<int>(std::clamp(pixels / kLeastPixels, 1.0, kLargestStep));
}

/// Neighbouring pixels mostly lie in one cell: each is looked up once for a run of them.
Cells collectCells(const ObjectConfig& config, const std::vector<ObjectView>& views,
                   const Grid& grid, const Aabb& extent, double cell_m) {
  Cells cells;
  for (const ObjectView& view : views) {
    CellKey last = 0;
    CellRecord* record = nullptr;
    const int step = findStep(view, extent, cell_m);
    forEachPoint(config, view, grid, step, [&](int, int, CellKey cell) {
      if (record == nullptr || cell != last) record = &cells[cell];
      last = cell;
      ++record->points;
    });
  }
  return cells;
}

/// @param i  0 to 26; 13 is the cell itself
CellKey findNeighbour(CellKey cell, CellKey i) {
  return cell + (i % 3) * kStepX + (i / 3 % 3) * kStepY + (i / 9) * kStepZ -
         (kStepX + kStepY + kStepZ);
}

/// Numbers the parts and returns how many points each has.
std::vector<std::size_t> findParts(Cells& cells) {
  std::vector<std::size_t> points;
  for (auto& [start, first] : cells) {
    if (first.part >= 0) continue;
    const int part = static_cast<int>(points.size());
    points.push_back(0);
    first.part = part;
    std::vector<CellKey> open{start};
    while (!open.empty()) {
      const CellKey cell = open.back();
      open.pop_back();
      points.back() += cells.at(cell).points;
      for (CellKey i = 0; i < 27; ++i) {
        const CellKey neighbour = findNeighbour(cell, i);
        const auto found = cells.find(neighbour);
        if (found == cells.end() || found->second.part >= 0) continue;
        found->second.part = part;
        open.push_back(neighbour);
      }
    }
  }
  return points;
}

/// A cell that no sampled pixel fell into goes with what it touches.
bool isKept(const Cells& cells, const std::vector<bool>& is_stray, CellKey cell) {
  const auto isKeptPart = [&](Cells::const_iterator found) {
    return found != cells.end() && !is_stray[static_cast<std::size_t>(found->second.part)];
  };
  const auto found = cells.find(cell);
  if (found != cells.end()) return isKeptPart(found);
  for (CellKey i = 0; i < 27; ++i) {
    if (isKeptPart(cells.find(findNeighbour(cell, i)))) return true;
  }
  return false;
}

/// Labels are shared with other objects' views: a view with stray pixels gets labels of its own.
void removeStray(const ObjectConfig& config, const Cells& cells, const std::vector<bool>& is_stray,
                 const Grid& grid, ObjectView& view) {
  cv::Mat labels;
  forEachPoint(config, view, grid, 1, [&](int u, int v, CellKey cell) {
    if (isKept(cells, is_stray, cell)) return;
    if (labels.empty()) labels = view.labels.clone();
    labels.at<std::uint16_t>(v, u) = 0;
  });
  if (!labels.empty()) view.labels = labels;
}

}  // namespace

Aabb keepMainPart(const ObjectConfig& config, const Aabb& extent, std::vector<ObjectView>& views) {
  Aabb kept = extent;
  for (int round = 0; round < kMaxRounds && !kept.isEmpty(); ++round) {
    const double cell_m = findCellSize(config, kept, views);
    const Grid grid(kept, cell_m);
    Cells cells = collectCells(config, views, grid, kept, cell_m);
    const std::vector<std::size_t> points = findParts(cells);
    if (points.size() < 2) break;  // one part; or none, where no sampled pixel meets thin masks
    const double least = config.min_part_share *
                         static_cast<double>(*std::max_element(points.begin(), points.end()));
    std::vector<bool> is_stray;
    for (const std::size_t count : points) is_stray.push_back(static_cast<double>(count) < least);
    if (std::find(is_stray.begin(), is_stray.end(), true) == is_stray.end()) break;
    for (ObjectView& view : views) removeStray(config, cells, is_stray, grid, view);
    kept = computeExtent(config, views);
  }
  return kept;
}

}  // namespace tsg::mapping
