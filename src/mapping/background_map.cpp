// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/background_map.h"

#include <algorithm>
#include <limits>
#include <map>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/parallel.h"
#include "task_scene_graph/mapping/marching_cubes.h"

namespace tsg::mapping {
namespace {

constexpr double kArchivePeriod_s = 1.0;

struct Before {
  bool operator()(const GridIndex& a, const GridIndex& b) const { return isBefore(a, b); }
};

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
}

IntegrationResult BackgroundMap::integrate(const RgbdFrame& frame) {
  IntegrationResult result = integrator_.integrate(frame, volume_);
  countFrame(frame, result.status);
  for (const auto& block : result.observed_blocks) last_seen_[block] = newest_;
  if (config_.with_mesh) dirty_.insert(result.changed_blocks.begin(), result.changed_blocks.end());
  const bool is_due = secondsBetween(last_archived_, newest_) >= kArchivePeriod_s;
  if (config_.archive_blocks && is_due) {
    last_archived_ = newest_;
    result.archived_blocks = findBlocksToArchive(frame.T_world_camera.translation());
    archive(result.archived_blocks);
  }
  return result;
}

void BackgroundMap::countFrame(const RgbdFrame& frame, IntegrationStatus status) {
  const bool is_first = counters_.frames_integrated + counters_.frames_without_depth == 0;
  if (!is_first && frame.stamp == newest_) ++counters_.frames_repeated;
  if (!is_first && frame.stamp < newest_) ++counters_.frames_back_in_time;
  if (status == IntegrationStatus::kIntegrated) countJump(frame);
  newest_ = is_first ? frame.stamp : std::max(newest_, frame.stamp);
  ++(status == IntegrationStatus::kIntegrated ? counters_.frames_integrated
                                              : counters_.frames_without_depth);
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
  for (const auto& [block, seen] : last_seen_) {
    if (secondsBetween(seen, newest_) <= config_.archive_unseen_s) continue;
    const Eigen::Vector3d center_m = (block.cast<double>().array() + 0.5) * block_size_m;
    if ((center_m - camera_m).norm() > config_.archive_distance_m) found.push_back(block);
  }
  std::sort(found.begin(), found.end(), isBefore);
  return found;
}

void BackgroundMap::archive(const std::vector<GridIndex>& blocks) {
  const auto readers = config_.with_mesh ? computeReaders(blocks) : std::vector<GridIndex>{};
  keepMeshes(readers);
  for (const auto& block : blocks) {
    if (volume_.findBlock(block) == nullptr) continue;
    volume_.removeBlock(block);
    last_seen_.erase(block);
    ++counters_.blocks_archived;
  }
  parkMeshes(readers);
}

void BackgroundMap::keepMeshes(const std::vector<GridIndex>& readers) {
  // Neighbours that stay lose the cells that read the dropped voxels, so their mesh is kept too.
  const auto meshes = computeMeshes(readers);
  for (std::size_t i = 0; i < readers.size(); ++i) {
    if (meshes[i]) archived_.store(readers[i], *meshes[i]);
  }
}

void BackgroundMap::parkMeshes(const std::vector<GridIndex>& readers) {
  for (const auto& block : readers) {
    const auto mesh = meshes_.find(block);
    const bool is_known = mesh != meshes_.end() && archived_.contains(block);
    if (is_known && !isActive(block)) mesh->second = nullptr;
  }
}

bool BackgroundMap::isActive(const GridIndex& block) const {
  for (int i = 0; i < 8; ++i) {
    if (volume_.findBlock(block + cornerStep(i)) != nullptr) return true;
  }
  return false;
}

std::vector<GridIndex> BackgroundMap::computeStaleBlocks() const {
  auto readers = computeReaders(dirty_);
  const auto has_surface = [&](const GridIndex& block) {
    return volume_.findBlock(block) != nullptr || meshes_.count(block) != 0 ||
           archived_.contains(block);
  };
  readers.erase(std::remove_if(readers.begin(), readers.end(),
                               [&](const GridIndex& block) { return !has_surface(block); }),
                readers.end());
  return readers;
}

std::vector<BackgroundMap::MeshPtr> BackgroundMap::computeMeshes(
    const std::vector<GridIndex>& blocks) const {
  std::vector<MeshPtr> meshes(blocks.size());
  parallelFor(blocks.size(), config_.tsdf.num_threads,
              [&](std::size_t i) { meshes[i] = computeMeshWithArchive(blocks[i]); });
  return meshes;
}

BackgroundMap::MeshPtr BackgroundMap::computeMeshWithArchive(const GridIndex& block) const {
  Mesh mesh = computeBlockMesh(volume_, block, config_.mesh_min_weight);
  if (archived_.contains(block)) {
    const double voxel_size_m = volume_.voxelSize();
    mesh.append(filterTriangles(archived_.load(block), [&](const Eigen::Vector3d& centroid_m) {
      const GridIndex cell = (centroid_m.array() / voxel_size_m - 0.5).floor().cast<int>().matrix();
      return !isCellKnown(cell);
    }));
  }
  return mesh.isEmpty() ? nullptr : std::make_shared<const Mesh>(std::move(mesh));
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
  for (std::size_t i = 0; i < stale.size(); ++i) {
    if (meshes[i]) {
      const bool is_parked = archived_.contains(stale[i]) && !isActive(stale[i]);
      meshes_[stale[i]] = is_parked ? nullptr : meshes[i];
      update.changed.push_back({stale[i], meshes[i]});
    } else if (meshes_.erase(stale[i]) != 0) {
      update.removed.push_back(stale[i]);
    }
  }
  counters_.blocks_remeshed += stale.size();
  dirty_.clear();
  return update;
}

std::vector<GridIndex> BackgroundMap::meshBlocks() const {
  std::vector<GridIndex> blocks;
  blocks.reserve(meshes_.size());
  for (const auto& [block, mesh] : meshes_) blocks.push_back(block);
  std::sort(blocks.begin(), blocks.end(), isBefore);
  return blocks;
}

std::shared_ptr<const Mesh> BackgroundMap::findMesh(const GridIndex& block) const {
  const auto mesh = meshes_.find(block);
  if (mesh == meshes_.end()) return nullptr;
  return mesh->second ? mesh->second : std::make_shared<const Mesh>(archived_.load(block));
}

Mesh BackgroundMap::extractMesh() const {
  std::map<GridIndex, MeshPtr, Before> current(meshes_.begin(), meshes_.end());
  const auto stale = computeStaleBlocks();
  const auto fresh = computeMeshes(stale);
  for (std::size_t i = 0; i < stale.size(); ++i) {
    if (fresh[i]) {
      current[stale[i]] = fresh[i];
    } else {
      current.erase(stale[i]);
    }
  }
  Mesh all;
  for (const auto& [block, mesh] : current) {
    all.append(mesh ? *mesh : archived_.load(block));
  }
  return weldVertices(all);
}

}  // namespace tsg::mapping
