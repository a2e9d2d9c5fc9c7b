// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/core/set_names.h"

namespace tsg::scene_graph {

/// Disjoint sets of places, each ascending, the sets by their smallest place.
using PlaceGroups = std::vector<std::vector<PlaceId>>;

/// Joins groups of fewer than `min_places` to the neighbour that they are joined to most: the sum
/// of the clearances of the edges between them (equal: the one with the smallest place). The
/// smallest group goes first (equal: the smallest place). One without neighbours stays.
/// Places of `edges` that are in no group do not count. O((places + edges) log).
PlaceGroups absorbSmallGroups(PlaceGroups groups, const std::vector<PlaceEdge>& edges,
                              std::size_t min_places);

/// Ids that follow groups as they change.
class RegionIds {
 public:
  /// Ids of the groups, in their order. A group gets the id of the former group with which it
  /// shares most places, the largest shares first (equal: the smaller id, then the earlier group);
  /// each id goes to one group. But groups of exactly the places of one of before have their id
  /// again, unless it would go to a group that has none of its own. The others get new ones; none
  /// goes to places none of which it ever named. O(places + changed groups' places log).
  std::vector<RegionId> match(const PlaceGroups& groups);
  /// Takes ids for those of the call before. @param places_of  by id
  void adopt(const std::map<RegionId, std::vector<PlaceId>>& places_of);

 private:
  static constexpr std::size_t kMaxNames = 10000;

  using PlaceRegions = std::vector<std::pair<PlaceId, RegionId>>;  ///< ascending

  struct Share {
    std::size_t count = 0;  ///< places that they have in common
    RegionId id;            ///< of the former group
    std::size_t group = 0;
  };

  PlaceRegions matchUnchanged(const PlaceGroups& groups, std::vector<RegionId>& ids) const;
  static std::vector<Share> findShares(const PlaceGroups& groups, const PlaceRegions& region_of);
  /// Gives groups that were there before their ids.
  static void claimKnown(const std::vector<Share>& shares, const std::vector<RegionId>& known,
                         std::vector<RegionId>& ids);

  PlaceGroups groups_;         ///< of the last call
  std::vector<RegionId> ids_;  ///< ... and their ids
  SetNames names_{kMaxNames};  ///< ids by what they named
  std::uint64_t next_ = 1;
};

}  // namespace tsg::scene_graph
