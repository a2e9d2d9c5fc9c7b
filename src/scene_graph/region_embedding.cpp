// SPDX-License-Identifier: BSD-3-Clause
#include "region_embedding.h"

#include <algorithm>
#include <utility>

namespace tsg::scene_graph {
namespace {

using Members = std::vector<const Place*>;

bool holdsExactly(const std::vector<PlaceId>& places, Members::const_iterator begin,
                  Members::const_iterator end) {
  return std::equal(places.begin(), places.end(), begin, end,
                    [](PlaceId id, const Place* place) { return id == place->id; });
}

Eigen::Index findSize(const Members& members) {
  const auto first = std::find_if(members.begin(), members.end(), [](const Place* place) {
    return place->embedding.hasDirection();
  });
  return first == members.end() ? 0 : (*first)->embedding.size();
}

}  // namespace

Embedding RegionEmbedding::update(const Members& members, Eigen::Index size,
                                  const BlockSet& changed) {
  if (size == 0) size = findSize(members);
  std::vector<Block> blocks;
  if (size == std::exchange(size_, size)) blocks = std::move(blocks_);
  blocks_.clear();
  EmbeddingMean whole;
  auto old = blocks.begin();
  for (auto begin = members.begin(); begin != members.end();) {
    const std::uint64_t index = blockOf((*begin)->id);
    const auto end = std::find_if(begin, members.end(),
                                  [&](const Place* place) { return blockOf(place->id) != index; });
    while (old != blocks.end() && old->index < index) ++old;
    const bool is_kept = old != blocks.end() && old->index == index && changed.count(index) == 0 &&
                         holdsExactly(old->places, begin, end);
    if (is_kept) {
      blocks_.push_back(std::move(*old));
    } else {
      Block block{index, {}, {}};
      for (auto place = begin; place != end; ++place) {
        block.places.push_back((*place)->id);
        const SharedEmbedding& embedding = (*place)->embedding;
        if (embedding.hasDirection() && embedding.size() == size) block.mean.add(embedding);
      }
      blocks_.push_back(std::move(block));
    }
    whole.add(blocks_.back().mean);
    begin = end;
  }
  return whole.mean();
}

}  // namespace tsg::scene_graph
