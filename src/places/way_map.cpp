// SPDX-License-Identifier: BSD-3-Clause
#include "way_map.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace tsg::places {
namespace {

constexpr double kMaxPause_s = 5.0;
constexpr double kTopStep_m = 0.02;  ///< by which the highest ground is told apart
constexpr double kMaxDrift_m = 0.1;  ///< of the camera's height, until the way is laid anew
constexpr int kMinVotes = 25;        ///< columns of ground that tell the camera's height

double toSeconds(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

/// By column, then by level.
bool isBefore(const WayCell& a, const WayCell& b) {
  return std::tie(a.offset, a.level_m) < std::tie(b.offset, b.level_m);
}

}  // namespace

void WayMap::addPose(const CameraPose& pose) {
  if (pose.T_world_camera.matrix().allFinite()) waiting_.push_back(pose);
}

const std::vector<WayCell>& WayMap::cellsAt(const TileIndex& tile) const {
  static const std::vector<WayCell> kNone;
  const auto found = cells_.find(tile);
  return found == cells_.end() ? kNone : found->second;
}

std::vector<TileIndex> WayMap::tileIndices() const {
  std::vector<TileIndex> indices;
  for (const auto& [index, cells] : cells_) indices.push_back(index);
  std::sort(indices.begin(), indices.end());
  return indices;
}

std::optional<double> WayMap::cameraHeight() const {
  if (config_.free_space == FreeSpaceKind::kVolume) return 0.0;
  if (config_.camera_height_m > 0.0) return config_.camera_height_m;
  const std::uint32_t num_poses = std::accumulate(heights_.begin(), heights_.end(), 0U);
  if (num_poses == 0) return std::nullopt;
  std::uint32_t below = 0;
  int bin = 0;
  for (; 2 * (below + heights_[static_cast<std::size_t>(bin)]) < num_poses; ++bin) {
    below += heights_[static_cast<std::size_t>(bin)];
  }
  return (bin + 0.5) * kHeightBin_m;
}

/// The height over the lowest ground of some extent counts for this pose, the median of all poses
/// in the end.
void WayMap::countHeight(const CameraPose& pose, const std::vector<float>& ground_m) {
  std::array<int, kHeightBins> votes{};
  for (const float height_m : ground_m) {
    const double above_m = pose.T_world_camera.translation().z() - static_cast<double>(height_m);
    const auto bin = static_cast<int>(std::floor(above_m / kHeightBin_m));
    if (bin > 1 && bin < kHeightBins) ++votes[static_cast<std::size_t>(bin)];
  }
  for (std::size_t bin = votes.size() - 1; bin > 0; --bin) {
    // ground may lie on both sides of a bin's border
    if (votes[bin] + votes[bin - 1] < kMinVotes) continue;
    ++heights_[votes[bin] >= votes[bin - 1] ? bin : bin - 1];
    return;
  }
}

TileSet WayMap::advance(double voxel_size_m) {
  TileSet changed;
  const auto height_m = cameraHeight();
  if (!height_m) return changed;
  addSegments();
  if (num_laid_ == 0) laid_height_m_ = *height_m;
  if (std::abs(*height_m - laid_height_m_) > kMaxDrift_m) {
    for (const auto& [index, cells] : cells_) changed.insert(index);
    cells_.clear();
    num_laid_ = 0;
    laid_height_m_ = *height_m;
  }
  for (; num_laid_ < segments_.size(); ++num_laid_) {
    lay(segments_[num_laid_], voxel_size_m, changed);
  }
  return changed;
}

void WayMap::addSegments() {
  for (const CameraPose& pose : waiting_) {
    if (last_) {
      const Segment segment{last_->T_world_camera.translation(), pose.T_world_camera.translation()};
      const double length_m = (segment.to - segment.from).norm();
      const double pause_s = toSeconds(pose.stamp.ns - last_->stamp.ns);
      const bool is_jump = length_m > config_.max_way_gap_m || config_.max_way_gap_m == 0.0 ||
                           pause_s < 0.0 || pause_s > kMaxPause_s;
      const bool is_repeated =
          length_m == 0.0 && !segments_.empty() && segments_.back().to == segment.to;
      if (!is_jump && !is_repeated) segments_.push_back(segment);
    }
    last_ = pose;
  }
  waiting_.clear();
}

void WayMap::lay(const Segment& segment, double voxel_size_m, TileSet& changed) {
  const Eigen::Vector3d step = segment.to - segment.from;
  const int steps = 1 + static_cast<int>(std::ceil(step.norm() / (0.5 * voxel_size_m)));
  for (int i = 0; i <= steps; ++i) {
    cover(segment.from + step * (static_cast<double>(i) / steps), voxel_size_m, changed);
  }
}

void WayMap::cover(const Eigen::Vector3d& position, double voxel_size_m, TileSet& changed) {
  const double level_m = position.z() - laid_height_m_;
  const Column middle{static_cast<int>(std::floor(position.x() / voxel_size_m)),
                      static_cast<int>(std::floor(position.y() / voxel_size_m))};
  const auto reach = static_cast<int>(std::ceil(config_.body_radius_m / voxel_size_m));
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const Column column{middle.x + dx, middle.y + dy};
      const double x_m = (column.x + 0.5) * voxel_size_m - position.x();
      const double y_m = (column.y + 0.5) * voxel_size_m - position.y();
      const bool is_axis = dx == 0 && dy == 0;
      const double away_m = std::hypot(x_m, y_m);
      if (!is_axis && away_m > config_.body_radius_m) continue;
      addCell(column, level_m, away_m, is_axis, voxel_size_m, changed);
    }
  }
}

/// Of the heights of one level that counts at which the middle of the body was nearest; others
/// must be nearer by half a voxel, so that a way hardly changes when it is walked again.
void WayMap::addCell(const Column& column, double level_m, double away_m, bool is_axis,
                     double voxel_size_m, TileSet& changed) {
  const bool is_volume = config_.free_space == FreeSpaceKind::kVolume;
  const double tolerance_m = is_volume ? 0.5 * voxel_size_m : 2.0 * config_.max_step_m;
  if (is_volume) level_m = (std::floor(level_m / voxel_size_m) + 0.5) * voxel_size_m;
  const TileIndex tile = computeTile(column);
  std::vector<WayCell>& cells = cells_[tile];
  const int offset = computeOffset(column);
  const double reach_m = 0.5 * config_.body_height_m;
  double top_m = level_m;
  for (WayCell& cell : cells) {
    if (is_volume || cell.offset != offset) continue;
    const double above_m = level_m - cell.level_m;
    if (-above_m <= reach_m) top_m = std::max(top_m, cell.level_m);
    if (above_m > reach_m || level_m < cell.top_m + kTopStep_m) continue;
    cell.top_m = level_m;
    if (cell.climbs(config_.max_step_m)) changed.insert(tile);
  }
  for (WayCell& cell : cells) {
    if (cell.offset != offset || std::abs(cell.level_m - level_m) > tolerance_m) continue;
    const bool is_nearer = away_m < cell.away_m - 0.5 * voxel_size_m;
    if (!is_nearer && (cell.is_axis || !is_axis)) return;
    cell.is_axis = cell.is_axis || is_axis;
    if (is_nearer) {
      cell.away_m = away_m;
      cell.level_m = level_m;
      cell.top_m = std::max(cell.top_m, level_m);
      std::sort(cells.begin(), cells.end(), isBefore);
    }
    changed.insert(tile);
    return;
  }
  const WayCell cell{offset, level_m, is_axis, top_m, away_m};
  const auto at = std::upper_bound(cells.begin(), cells.end(), cell, isBefore);
  cells.insert(at, cell);
  changed.insert(tile);
}

WayMemory WayMap::memory() const {
  WayMemory memory;
  for (const Segment& segment : segments_) memory.segments.push_back({segment.from, segment.to});
  memory.camera_height_m = laid_height_m_;
  memory.height_counts.assign(heights_.begin(), heights_.end());
  memory.last = last_;
  memory.waiting = waiting_;
  return memory;
}

void WayMap::restore(const WayMemory& memory, double voxel_size_m) {
  *this = WayMap(config_);
  for (const auto& segment : memory.segments) segments_.push_back({segment.from_m, segment.to_m});
  const std::size_t num_counts = std::min(memory.height_counts.size(), heights_.size());
  std::copy_n(memory.height_counts.begin(), num_counts, heights_.begin());
  last_ = memory.last;
  waiting_ = memory.waiting;
  laid_height_m_ = memory.camera_height_m;
  TileSet ignored;
  for (; num_laid_ < segments_.size(); ++num_laid_) {
    lay(segments_[num_laid_], voxel_size_m, ignored);
  }
}

}  // namespace tsg::places
