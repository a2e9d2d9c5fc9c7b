// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <unordered_set>
#include <vector>

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/scene_graph/scoring.h"

namespace tsg::scene_graph {

/// Mean embedding of a region's places while the region grows and changes. Sums run over blocks of
/// neighbouring ids and are kept, so that of a large region only the blocks that changed are summed
/// anew; the order of summation is that of the ids either way, so that the mean does not depend on
/// what was kept, to the bit.
class RegionEmbedding {
 public:
  using BlockSet = std::unordered_set<std::uint64_t>;

  /// The block of a place: ids of one block were given one after the other, so they are mostly
  /// neighbours.
  static std::uint64_t blockOf(PlaceId id) { return id.value / kBlockSize; }

  /// The mean of what counts: embeddings of size `size` (0: of the first) that have a direction.
  /// @param members  ascending by id
  /// @param changed  blocks with places whose embedding may be another than at the last call
  /// O(members + D * members of new and changed blocks).
  Embedding update(const std::vector<const Place*>& members, Eigen::Index size,
                   const BlockSet& changed);

 private:
  static constexpr std::uint64_t kBlockSize = 64;

  struct Block {
    std::uint64_t index = 0;
    std::vector<PlaceId> places;
    EmbeddingMean mean;
  };

  std::vector<Block> blocks_;  ///< ascending by index
  Eigen::Index size_ = 0;      ///< of the embeddings that are summed
};

}  // namespace tsg::scene_graph
