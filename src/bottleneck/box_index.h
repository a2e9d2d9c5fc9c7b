// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "task_scene_graph/core/box.h"

namespace tsg::bottleneck {

/// Which boxes overlap a given one (sharing a volume; touching is not enough), without looking at
/// all pairs: an R-tree. Not thread-safe.
class BoxIndex {
 public:
  using Entry = std::pair<Aabb, std::uint32_t>;

  BoxIndex();
  ~BoxIndex();
  BoxIndex(BoxIndex&&) noexcept;
  BoxIndex& operator=(BoxIndex&&) noexcept;

  /// Adds boxes; many at once are packed. Empty boxes are left out: they overlap nothing.
  /// O(log n) each.
  void insert(const std::vector<Entry>& entries);
  /// Removes an entry as it was inserted. O(log n).
  void remove(const Entry& entry);
  /// Ids of the boxes that overlap `box`, ascending. O(log n + hits) for boxes of like size.
  std::vector<std::uint32_t> findOverlapping(const Aabb& box) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace tsg::bottleneck
