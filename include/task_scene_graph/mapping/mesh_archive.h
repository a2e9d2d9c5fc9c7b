// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <unordered_map>
#include <vector>

#include "task_scene_graph/core/mesh.h"
#include "task_scene_graph/mapping/tsdf_volume.h"

namespace tsg::mapping {

/// Meshes of blocks that are put away: compressed without loss to about a third, in a temporary
/// file without a name, so that it is gone with the process whatever happens. Where that file
/// cannot be made or written, they stay in memory.
class MeshArchive {
 public:
  MeshArchive() = default;

  /// Replaces what was there for this block. @throws std::runtime_error if memory runs out.
  void store(const GridIndex& block, const Mesh& mesh);

  /// The mesh, bit by bit. Precondition: contains(block). From any number of threads at once, as
  /// long as none stores. @throws std::runtime_error if the file cannot be read any more.
  Mesh load(const GridIndex& block) const;

  bool contains(const GridIndex& block) const { return entries_.count(block) != 0; }

  std::size_t fileBytes() const { return static_cast<std::size_t>(file_end_); }
  std::size_t memoryBytes() const { return memory_bytes_; }  ///< of meshes that are in no file

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  struct Entry {
    std::uint32_t vertices = 0;
    std::uint32_t triangles = 0;
    std::int64_t offset = 0;
    std::uint32_t size = 0;                            ///< compressed bytes
    std::uint32_t capacity = 0;                        ///< of the place in the file; 0 = in memory
    std::unique_ptr<std::vector<std::uint8_t>> bytes;  ///< only in memory
  };

  bool write(const std::vector<std::uint8_t>& bytes, Entry& entry);
  std::vector<std::uint8_t> read(const Entry& entry) const;

  std::unordered_map<GridIndex, Entry, GridIndexHash> entries_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  bool is_file_broken_ = false;
  std::int64_t file_end_ = 0;
  std::size_t memory_bytes_ = 0;
};

}  // namespace tsg::mapping
