// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/mesh_table.h"

#include <algorithm>
#include <map>

#include "task_scene_graph/mapping/marching_cubes.h"
#include "task_scene_graph/mapping/tsdf_integrator.h"

namespace tsg::mapping {
namespace {

struct Before {
  bool operator()(const GridIndex& a, const GridIndex& b) const { return isBefore(a, b); }
};

using Changes = std::map<GridIndex, StoredMesh, Before>;

/// The chunk with the changes in it.
std::shared_ptr<const MeshTable::Chunk> mergeChunk(const MeshTable::Chunk& old,
                                                   const Changes& changes) {
  auto merged = std::make_shared<MeshTable::Chunk>();
  auto change = changes.begin();
  const auto add = [&](const GridIndex& block, const StoredMesh& mesh) {
    if (!mesh.isNone()) merged->push_back({block, mesh});
  };
  for (const auto& entry : old) {
    for (; change != changes.end() && isBefore(change->first, entry.block); ++change) {
      add(change->first, change->second);
    }
    const bool is_replaced = change != changes.end() && change->first == entry.block;
    add(entry.block, is_replaced ? change->second : entry.mesh);
    if (is_replaced) ++change;
  }
  for (; change != changes.end(); ++change) add(change->first, change->second);
  return merged;
}

template <typename Sorted, typename Key>
auto findSorted(const Sorted& sorted, const GridIndex& index, const Key& key) {
  const auto found = std::lower_bound(
      sorted.begin(), sorted.end(), index,
      [&](const auto& item, const GridIndex& i) { return isBefore(key(item), i); });
  return found != sorted.end() && key(*found) == index ? found : sorted.end();
}

}  // namespace

std::shared_ptr<const Mesh> StoredMesh::load() const {
  if (record_ != nullptr) return std::make_shared<const Mesh>(record_->load());
  return mesh_;
}

GridIndex computeMeshChunk(const GridIndex& block) {
  static_assert(kMeshChunkSide == 4);
  return {block.x() >> 2, block.y() >> 2, block.z() >> 2};
}

MeshTable MeshTable::with(const std::vector<Entry>& changes) const {
  std::map<GridIndex, Changes, Before> by_chunk;
  for (const auto& entry : changes)
    by_chunk[computeMeshChunk(entry.block)][entry.block] = entry.mesh;
  static const Chunk kNoChunk;
  auto merged = std::make_shared<Chunks>();
  merged->reserve(chunks_->size() + by_chunk.size());
  const auto add = [&](const GridIndex& index, const Chunk& old, const Changes& in_chunk) {
    auto chunk = mergeChunk(old, in_chunk);
    if (!chunk->empty()) merged->emplace_back(index, std::move(chunk));
  };
  auto change = by_chunk.begin();
  for (const auto& old : *chunks_) {
    for (; change != by_chunk.end() && isBefore(change->first, old.first); ++change) {
      add(change->first, kNoChunk, change->second);
    }
    if (change != by_chunk.end() && change->first == old.first) {
      add(old.first, *old.second, change->second);
      ++change;
    } else {
      merged->push_back(old);
    }
  }
  for (; change != by_chunk.end(); ++change) add(change->first, kNoChunk, change->second);
  MeshTable table;
  table.chunks_ = std::move(merged);
  return table;
}

const MeshTable::Chunk* MeshTable::findChunk(const GridIndex& chunk) const {
  const auto found = findSorted(*chunks_, chunk, [](const auto& item) { return item.first; });
  return found == chunks_->end() ? nullptr : found->second.get();
}

StoredMesh MeshTable::find(const GridIndex& block) const {
  const Chunk* chunk = findChunk(computeMeshChunk(block));
  if (chunk == nullptr) return {};
  const auto found = findSorted(*chunk, block, [](const auto& item) { return item.block; });
  return found == chunk->end() ? StoredMesh() : found->mesh;
}

std::size_t MeshTable::numBlocks() const {
  std::size_t count = 0;
  for (const auto& [index, chunk] : *chunks_) count += chunk->size();
  return count;
}

std::vector<GridIndex> MeshTable::blocks() const {
  std::vector<GridIndex> blocks;
  for (const auto& [index, chunk] : *chunks_) {
    for (const auto& entry : *chunk) blocks.push_back(entry.block);
  }
  std::sort(blocks.begin(), blocks.end(), isBefore);
  return blocks;
}

std::vector<GridIndex> MeshTable::chunks() const {
  std::vector<GridIndex> chunks;
  chunks.reserve(chunks_->size());
  for (const auto& [index, chunk] : *chunks_) chunks.push_back(index);
  return chunks;
}

Mesh mergeMeshes(const MeshTable& table) {
  Mesh all;
  for (const auto& block : table.blocks()) all.append(*table.find(block).load());
  return weldVertices(all);
}

}  // namespace tsg::mapping
