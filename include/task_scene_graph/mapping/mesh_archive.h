// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>

#include "task_scene_graph/core/mesh.h"

namespace tsg::mapping {

/// Meshes that are put away: compressed without loss to about a third, in a temporary file without
/// a name, so that it is gone with the process whatever happens. Where that file cannot be made or
/// written, they stay in memory. Thread-safe.
class MeshArchive {
  class Storage;

 public:
  /// A mesh that was put away. It never changes; its place in the file is used again once nobody
  /// holds the record. Outlives the archive.
  class Record {
   public:
    ~Record();
    Record(const Record&) = delete;
    Record& operator=(const Record&) = delete;
    /// The mesh, bit by bit. @throws std::runtime_error if the file cannot be read any more.
    Mesh load() const;

   private:
    friend class MeshArchive;
    explicit Record(std::shared_ptr<Storage> storage);
    struct Place;

    std::shared_ptr<Storage> storage_;
    std::unique_ptr<const Place> place_;
  };
  using RecordPtr = std::shared_ptr<const Record>;

  MeshArchive();

  /// Never null. @throws std::runtime_error if memory runs out.
  RecordPtr store(const Mesh& mesh);

  /// Size of the file: at most what all records alive at one time ever took, rounded up to size
  /// classes (a fifth more at most).
  std::size_t fileBytes() const;
  std::size_t memoryBytes() const;  ///< of meshes that are in no file

 private:
  std::shared_ptr<Storage> storage_;
};

}  // namespace tsg::mapping
