// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/background_map.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/parallel.h"
#include "task_scene_graph/mapping/marching_cubes.h"

namespace tsg::mapping {
namespace {

constexpr double kArchivePeriod_s = 1.0;

GridIndex cornerStep(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2 & 1}; }

/// Blocks that have a cell which reads a voxel of one of these: each block and its lower
/// neighbours.
template <typename Indices>
std::vector<GridIndex> computeReaders(const Indices& blocks) {
  std::vector<GridIndex> readers;
  for (const auto& block : blocks) {
    for (int i = 0; i < 8; ++i) readers.push_back(block - cornerStep(i));
  }
  std::sort(readers.begin(), readers.end(), isBefore);
  readers.erase(std::unique(readers.begin(), readers.end()), readers.end());
  return readers;
}

/// Copies the triangles for which `keep(centroid)` holds, with their vertices.
template <typename Keep>
Mesh filterTriangles(const Mesh& mesh, const Keep& keep) {
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> new_index(mesh.vertices.size(), kUnused);
  Mesh kept;
  for (auto triangle : mesh.triangles) {
    const Eigen::Vector3f sum =
        mesh.vertices[triangle[0]] + mesh.vertices[triangle[1]] + mesh.vertices[triangle[2]];
    if (!keep(Eigen::Vector3d(sum.cast<double>() / 3.0))) continue;
    for (auto& vertex : triangle) {
      if (new_index[vertex] == kUnused) {
        new_index[vertex] = static_cast<std::uint32_t>(kept.vertices.size());
        kept.vertices.push_back(mesh.vertices[vertex]);
        kept.colors.push_back(mesh.colors[vertex]);
      }
      vertex = new_index[vertex];
    }
    kept.triangles.push_back(triangle);
  }
  return kept;
}

}  // namespace

BackgroundMap::BackgroundMap(const BackgroundConfig& config)
    : config_(config), integrator_(config.tsdf), volume_(config.tsdf.voxel_size_m) {
  config::validate(config, "background map");
  if (config.tsdf.carve_free_space && !config.with_mesh) thin_.emplace(config.tsdf);
}

IntegrationResult BackgroundMap::integrate(const RgbdFrame& frame) {
  IntegrationResult result = integrator_.integrate(frame, volume_);
  countFrame(frame, result.status);
  for (const auto& block : result.observed_blocks) last_seen_s_[block] = clock_s_;
  dirty_.insert(result.changed_blocks.begin(), result.changed_blocks.end());
  if (thin_ && result.status == IntegrationStatus::kIntegrated) {
    const auto changed = thin_->add(frame, volume_, result.observed_blocks);
    dirty_.insert(changed.begin(), changed.end());
  }
  if (config_.archive_blocks && clock_s_ - archived_at_s_ >= kArchivePeriod_s) {
    archived_at_s_ = clock_s_;
    result.archived_blocks = findBlocksToArchive(frame.T_world_camera.translation());
    archive(result.archived_blocks);
  }
  return result;
}

void BackgroundMap::countFrame(const RgbdFrame& frame, IntegrationStatus status) {
  if (newest_ && frame.stamp == *newest_) ++counters_.frames_repeated;
  if (newest_ && frame.stamp < *newest_) ++counters_.frames_back_in_time;
  if (status == IntegrationStatus::kIntegrated) countJump(frame);
  advanceClock(frame.stamp);
  ++(status == IntegrationStatus::kIntegrated ? counters_.frames_integrated
                                              : counters_.frames_without_depth);
}

void BackgroundMap::advanceClock(Stamp stamp) {
  if (newest_) {
    // One frame of the past among others takes no time; a past that goes on does.
    const Stamp before = *newest_ < stamp ? *newest_ : previous_;
    clock_s_ += std::max(0.0, secondsBetween(before, stamp));
  }
  newest_ = newest_ ? std::max(*newest_, stamp) : stamp;
  previous_ = stamp;
}

void BackgroundMap::countJump(const RgbdFrame& frame) {
  const Eigen::Vector3d position_m = frame.T_world_camera.translation();
  const bool has_jumped =
      last_position_m_ && (position_m - *last_position_m_).norm() > config_.pose_jump_m;
  counters_.pose_jumps += has_jumped ? 1 : 0;
  last_position_m_ = position_m;
}

std::vector<GridIndex> BackgroundMap::findBlocksToArchive(const Eigen::Vector3d& camera_m) const {
  std::vector<GridIndex> found;
  const double block_size_m = volume_.voxelSize() * kBlockSide;
  for (const auto& [block, seen_s] : last_seen_s_) {
    if (clock_s_ - seen_s <= config_.archive_unseen_s) continue;
    const Eigen::Vector3d center_m = (block.cast<double>().array() + 0.5) * block_size_m;
    if ((center_m - camera_m).norm() > config_.archive_distance_m) found.push_back(block);
  }
  std::sort(found.begin(), found.end(), isBefore);
  return found;
}

void BackgroundMap::restore(const std::vector<BlockMesh>& blocks) {
  if (!volume_.blocks().empty()) {
    throw std::logic_error("background map: frames are in it, expected none when it is restored");
  }
  archived_.clear();
  std::vector<MeshArchive::RecordPtr> records(blocks.size());
  parallelFor(blocks.size(), config_.tsdf.num_threads, [&](std::size_t i) {
    if (!blocks[i].mesh->isEmpty() && config_.with_mesh)
      records[i] = archive_.store(*blocks[i].mesh);
  });
  std::vector<MeshTable::Entry> entries;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (records[i] == nullptr) continue;
    archived_[blocks[i].block] = records[i];
    entries.push_back({blocks[i].block, StoredMesh(records[i])});
  }
  meshes_ = MeshTable().with(entries);
}

void BackgroundMap::archive(const std::vector<GridIndex>& blocks) {
  const auto readers = config_.with_mesh ? computeReaders(blocks) : std::vector<GridIndex>{};
  keepMeshes(readers);
  for (const auto& block : blocks) {
    if (volume_.findBlock(block) == nullptr) continue;
    volume_.removeBlock(block);
    if (thin_) thin_->erase(block);
    last_seen_s_.erase(block);
    ++counters_.blocks_archived;
  }
  parkMeshes(readers);
}

void BackgroundMap::keepMeshes(const std::vector<GridIndex>& readers) {
  // Neighbours that stay lose the cells that read the dropped voxels, so their mesh is kept too.
  const auto meshes = computeMeshes(readers);
  for (std::size_t i = 0; i < readers.size(); ++i) {
    if (meshes[i]) archived_[readers[i]] = archive_.store(*meshes[i]);
  }
}

void BackgroundMap::parkMeshes(const std::vector<GridIndex>& readers) {
  std::vector<MeshTable::Entry> parked;
  for (const auto& block : readers) {
    const auto record = archived_.find(block);
    const bool is_known = record != archived_.end() && !meshes_.find(block).isNone();
    if (is_known && !isActive(block)) parked.push_back({block, StoredMesh(record->second)});
  }
  if (!parked.empty()) meshes_ = meshes_.with(parked);
}

bool BackgroundMap::isActive(const GridIndex& block) const {
  for (int i = 0; i < 8; ++i) {
    if (volume_.findBlock(block + cornerStep(i)) != nullptr) return true;
  }
  return false;
}

std::vector<GridIndex> BackgroundMap::computeStaleBlocks() const {
  if (!config_.with_mesh) return {};
  auto readers = computeReaders(dirty_);
  const auto has_surface = [&](const GridIndex& block) {
    return volume_.findBlock(block) != nullptr || archived_.count(block) != 0 ||
           !meshes_.find(block).isNone();
  };
  readers.erase(std::remove_if(readers.begin(), readers.end(),
                               [&](const GridIndex& block) { return !has_surface(block); }),
                readers.end());
  return readers;
}

std::vector<BackgroundMap::MeshPtr> BackgroundMap::computeMeshes(
    const std::vector<GridIndex>& blocks) const {
  std::vector<MeshPtr> meshes(blocks.size());
  parallelFor(blocks.size(), config_.tsdf.num_threads, [&](std::size_t i) {
    Mesh mesh = computeBlockMesh(volume_, blocks[i], config_.mesh_min_weight);
    if (archived_.count(blocks[i]) != 0) appendArchived(blocks[i], mesh);
    if (!mesh.isEmpty()) meshes[i] = std::make_shared<const Mesh>(std::move(mesh));
  });
  return meshes;
}

void BackgroundMap::appendArchived(const GridIndex& block, Mesh& mesh) const {
  const double voxel_size_m = volume_.voxelSize();
  mesh.append(filterTriangles(archived_.at(block)->load(), [&](const Eigen::Vector3d& centroid_m) {
    const GridIndex cell = (centroid_m.array() / voxel_size_m - 0.5).floor().cast<int>().matrix();
    return !isCellKnown(cell);
  }));
}

bool BackgroundMap::isCellKnown(const GridIndex& lowest_voxel) const {
  for (int i = 0; i < 8; ++i) {
    const TsdfVoxel* voxel = volume_.findVoxel(lowest_voxel + cornerStep(i));
    if (voxel == nullptr || !(voxel->weight > config_.mesh_min_weight)) return false;
  }
  return true;
}

MeshUpdate BackgroundMap::updateMesh() {
  MeshUpdate update;
  const auto stale = computeStaleBlocks();
  const auto meshes = computeMeshes(stale);
  std::vector<MeshTable::Entry> changes;
  for (std::size_t i = 0; i < stale.size(); ++i) {
    const auto record = archived_.find(stale[i]);
    const bool is_parked = meshes[i] && record != archived_.end() && !isActive(stale[i]);
    changes.push_back({stale[i], is_parked ? StoredMesh(record->second) : StoredMesh(meshes[i])});
    if (meshes[i]) {
      update.changed.push_back({stale[i], meshes[i]});
    } else if (!meshes_.find(stale[i]).isNone()) {
      update.removed.push_back(stale[i]);
    }
  }
  meshes_ = meshes_.with(changes);
  counters_.blocks_remeshed += stale.size();
  if (config_.with_mesh) dirty_.clear();
  return update;
}

Mesh BackgroundMap::extractMesh() const {
  const auto stale = computeStaleBlocks();
  const auto meshes = computeMeshes(stale);
  std::vector<MeshTable::Entry> changes;
  for (std::size_t i = 0; i < stale.size(); ++i) {
    changes.push_back({stale[i], StoredMesh(meshes[i])});
  }
  return mergeMeshes(meshes_.with(changes));
}

TsdfVolume BackgroundMap::takeChangedBlocks() {
  TsdfVolume changed(volume_.voxelSize());
  for (const auto& index : dirty_) {
    const TsdfBlock* block = volume_.findBlock(index);
    if (block == nullptr) continue;
    TsdfBlock& copy = changed.allocateBlock(index);
    copy = *block;
    if (thin_) thin_->mark(volume_, copy);
  }
  dirty_.clear();
  return changed;
}

}  // namespace tsg::mapping
