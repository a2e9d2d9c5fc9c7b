// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "task_scene_graph/core/mesh.h"
#include "task_scene_graph/mapping/mesh_archive.h"
#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::mapping {

/// The mesh of a block: in memory, put away, or none.
class StoredMesh {
 public:
  StoredMesh() = default;
  explicit StoredMesh(std::shared_ptr<const Mesh> mesh) : mesh_(std::move(mesh)) {}
  explicit StoredMesh(MeshArchive::RecordPtr record) : record_(std::move(record)) {}

  bool isNone() const { return mesh_ == nullptr && record_ == nullptr; }
  bool isInMemory() const { return mesh_ != nullptr; }
  /// Null if there is none. One read of the archive's file where it is put away.
  /// @throws std::runtime_error as MeshArchive::Record::load().
  std::shared_ptr<const Mesh> load() const;

 private:
  std::shared_ptr<const Mesh> mesh_;
  MeshArchive::RecordPtr record_;
};

/// Blocks are kept and drawn in cubes of kMeshChunkSide^3.
constexpr int kMeshChunkSide = 4;
GridIndex computeMeshChunk(const GridIndex& block);

/// The meshes of all blocks at one moment: a value that never changes and shares with the tables
/// before and after it all chunks that are alike. To copy one is to copy a pointer. Thread-safe.
class MeshTable {
 public:
  struct Entry {
    GridIndex block;
    StoredMesh mesh;
  };
  using Chunk = std::vector<Entry>;  ///< ascending by (z, y, x); none without a mesh

  /// A table with these meshes in the place of those of before; a mesh that is none takes its block
  /// out. Each block occurs once at most. O(changes * log(chunks) + chunks).
  MeshTable with(const std::vector<Entry>& changes) const;

  /// None if the block has no mesh. O(log(blocks)).
  StoredMesh find(const GridIndex& block) const;
  /// Null if no block of the chunk has a mesh. O(log(chunks)).
  const Chunk* findChunk(const GridIndex& chunk) const;

  std::size_t numBlocks() const;
  /// Ascending by (z, y, x). O(blocks log(blocks)).
  std::vector<GridIndex> blocks() const;
  /// Ascending by (z, y, x). O(chunks).
  std::vector<GridIndex> chunks() const;

 private:
  /// Ascending by (z, y, x); none is empty.
  using Chunks = std::vector<std::pair<GridIndex, std::shared_ptr<const Chunk>>>;

  std::shared_ptr<const Chunks> chunks_ = std::make_shared<const Chunks>();
};

/// All meshes of the table as one, in ascending order of the blocks, welded across their borders.
/// O(vertices). @throws std::runtime_error as MeshArchive::Record::load().
Mesh mergeMeshes(const MeshTable& table);

}  // namespace tsg::mapping
