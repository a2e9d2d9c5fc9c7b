// SPDX-License-Identifier: BSD-3-Clause
#include "scene_graph/region_groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

namespace tsg::scene_graph {
namespace {

using Ids = std::vector<PlaceId>;

TEST(SmallGroups, JoinTheNeighbourWithTheWidestConnection) {
  const PlaceGroups groups{{{1}, {2}, {3}}, {{4}}, {{5}, {6}, {7}}};
  const std::vector<PlaceEdge> edges{{{3}, {4}, 0.5}, {{4}, {5}, 0.3}, {{4}, {6}, 0.3}};
  EXPECT_EQ(absorbSmallGroups(groups, edges, 2),
            (PlaceGroups{{{1}, {2}, {3}}, {{4}, {5}, {6}, {7}}}));
}

TEST(SmallGroups, GoWithTheSmallestPlaceWhereConnectionsAreEqual) {
  const PlaceGroups groups{{{2}, {3}}, {{4}}, {{1}, {6}}};
  const std::vector<PlaceEdge> edges{{{3}, {4}, 0.5}, {{1}, {4}, 0.5}};
  EXPECT_EQ(absorbSmallGroups(groups, edges, 2), (PlaceGroups{{{1}, {4}, {6}}, {{2}, {3}}}));
}

TEST(SmallGroups, JoinEachOtherUntilTheyAreLargeEnough) {
  const PlaceGroups groups{{{1}}, {{2}}, {{3}}, {{4}, {5}, {6}}};
  const std::vector<PlaceEdge> edges{{{1}, {2}, 0.9}, {{2}, {3}, 0.8}, {{3}, {4}, 0.1}};
  EXPECT_EQ(absorbSmallGroups(groups, edges, 3), (PlaceGroups{{{1}, {2}, {3}}, {{4}, {5}, {6}}}));
}

TEST(SmallGroups, StayWhereNothingIsJoinedToThem) {
  const PlaceGroups groups{{{1}}, {{2}, {3}}};
  EXPECT_EQ(absorbSmallGroups(groups, {{{1}, {9}, 1.0}}, 3), groups);
}

TEST(SmallGroups, OfOneAreLeftAloneIfAnySizeIsAllowed) {
  const PlaceGroups groups{{{1}}, {{2}}};
  EXPECT_EQ(absorbSmallGroups(groups, {{{1}, {2}, 1.0}}, 1), groups);
}

TEST(RegionIds, StayWithTheGroupThatSharesMostPlaces) {
  RegionIds ids;
  EXPECT_EQ(ids.match({{{1}, {2}, {3}}, {{4}, {5}}}), (std::vector<RegionId>{{1}, {2}}));
  // Place 1 leaves the first, which splits; the second takes it in.
  EXPECT_EQ(ids.match({{{1}, {4}, {5}}, {{2}}, {{3}}}), (std::vector<RegionId>{{2}, {1}, {3}}));
  EXPECT_EQ(ids.match({{{1}, {4}, {5}}, {{2}}, {{3}}}), (std::vector<RegionId>{{2}, {1}, {3}}));
}

TEST(RegionIds, NeverGoToOtherPlaces) {
  RegionIds ids;
  ids.match({{{1}}, {{2}}});
  EXPECT_EQ(ids.match({{{2}}}), (std::vector<RegionId>{{2}}));
  EXPECT_EQ(ids.match({{{2}}, {{3}}}), (std::vector<RegionId>{{2}, {3}}));
}

TEST(RegionIds, OfGroupsThatFormAgainAreTheirsAgain) {
  RegionIds ids;
  const PlaceGroups three{{{1}, {2}, {3}}, {{4}, {5}}, {{6}}};
  const std::vector<RegionId> first = ids.match(three);
  EXPECT_EQ(ids.match({{{1}, {2}, {3}, {4}, {5}}, {{6}}}), (std::vector<RegionId>{{1}, {3}}));
  EXPECT_EQ(ids.match({{{1}, {2}, {3}, {4}, {5}, {6}}}), (std::vector<RegionId>{{1}}));
  EXPECT_EQ(ids.match(three), first);
}

TEST(RegionIds, AreKeptByTheLargerPartAlthoughTheSmallerBeganThem) {
  RegionIds ids;
  ids.match({{{1}}});
  ids.match({{{1}, {2}, {3}}});
  EXPECT_EQ(ids.match({{{1}}, {{2}, {3}}}), (std::vector<RegionId>{{2}, {1}}));
}

TEST(RegionIds, OfAMapOfBeforeLeaveNoneOfThoseThatWereThere) {
  RegionIds ids;
  ids.match({{{1}, {2}}, {{3}}});
  ids.match({{{1}, {2}, {3}}});
  ids.adopt({{{7}, {{1}, {2}}}});
  EXPECT_EQ(ids.match({{{1}, {2}}, {{3}}}), (std::vector<RegionId>{{7}, {8}}));
}

/// The rule as it is written, pair by pair.
std::vector<RegionId> matchPairByPair(const PlaceGroups& groups, const PlaceGroups& before,
                                      const std::vector<RegionId>& ids_before,
                                      std::uint64_t& next) {
  std::vector<RegionId> ids(groups.size());
  std::set<RegionId> taken;
  for (std::size_t count = 100; count > 0; --count) {
    std::map<RegionId, std::vector<std::size_t>> pairs;
    for (std::size_t k = 0; k < before.size(); ++k) {
      for (std::size_t i = 0; i < groups.size(); ++i) {
        Ids shared;
        std::set_intersection(groups[i].begin(), groups[i].end(), before[k].begin(),
                              before[k].end(), std::back_inserter(shared));
        if (shared.size() == count) pairs[ids_before[k]].push_back(i);
      }
    }
    for (const auto& [id, candidates] : pairs) {
      for (const std::size_t i : candidates) {
        if (!ids[i].isValid() && taken.insert(id).second) ids[i] = id;
      }
    }
  }
  for (RegionId& id : ids) {
    if (!id.isValid()) id = RegionId{next++};
  }
  return ids;
}

/// Places 1 to 60, some of them missing, in up to twelve groups; from time to time one moves.
TEST(RegionIds, FollowRandomGroupsByTheRule) {
  std::mt19937 random(5);
  const auto draw = [&](unsigned count) { return static_cast<unsigned>(random() % count); };
  std::vector<unsigned> label(60);
  for (unsigned& value : label) value = draw(12);
  RegionIds ids;
  PlaceGroups before;
  std::vector<RegionId> ids_before;
  std::uint64_t next = 1;
  for (int round = 0; round < 200; ++round) {
    for (unsigned change = draw(6); change > 0; --change) label[draw(60)] = draw(14);
    std::map<unsigned, Ids> members;
    for (unsigned place = 0; place < 60; ++place) {
      if (label[place] < 12) members[label[place]].push_back({place + 1});
    }
    PlaceGroups groups;
    for (auto& [name, places] : members) groups.push_back(places);
    std::sort(groups.begin(), groups.end());
    const auto expected = matchPairByPair(groups, before, ids_before, next);
    ASSERT_EQ(ids.match(groups), expected) << "round " << round;
    before = groups;
    ids_before = expected;
  }
}

/// The rule as it is written, over the sums of all edges between each two groups.
PlaceGroups absorbOneByOne(PlaceGroups groups, const std::vector<PlaceEdge>& edges,
                           std::size_t min_places) {
  const auto holds = [](const Ids& group, PlaceId place) {
    return std::find(group.begin(), group.end(), place) != group.end();
  };
  const auto addUp = [&](const Ids& a, const Ids& b) {
    double sum_m = 0.0;
    for (const PlaceEdge& edge : edges) {
      const bool is_between =
          (holds(a, edge.a) && holds(b, edge.b)) || (holds(a, edge.b) && holds(b, edge.a));
      sum_m += is_between ? edge.clearance_m : 0.0;
    }
    return sum_m;
  };
  while (true) {
    for (Ids& group : groups) std::sort(group.begin(), group.end());
    std::sort(groups.begin(), groups.end());
    std::size_t from = groups.size();
    std::size_t to = groups.size();
    for (std::size_t i = 0; i < groups.size(); ++i) {
      if (groups[i].size() >= min_places) continue;
      if (from < groups.size() && groups[from].size() <= groups[i].size()) continue;
      double widest_m = 0.0;
      std::size_t widest = groups.size();
      for (std::size_t k = 0; k < groups.size(); ++k) {
        const double sum_m = k == i ? 0.0 : addUp(groups[i], groups[k]);
        if (sum_m > widest_m) widest = k;
        widest_m = std::max(widest_m, sum_m);
      }
      if (widest == groups.size()) continue;
      from = i;
      to = widest;
    }
    if (from == groups.size()) return groups;
    groups[to].insert(groups[to].end(), groups[from].begin(), groups[from].end());
    groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(from));
  }
}

/// Clearances are eighths of a metre, so that sums are exact in any order.
TEST(SmallGroups, OfRandomGraphsJoinByTheRule) {
  std::mt19937 random(6);
  const auto draw = [&](unsigned count) { return static_cast<unsigned>(random() % count); };
  for (int round = 0; round < 60; ++round) {
    std::map<unsigned, Ids> members;
    for (unsigned place = 1; place <= 40; ++place) {
      const unsigned label = draw(3) == 0 ? draw(30) : draw(4);
      if (place % 9 != 0) members[label].push_back({place});
    }
    PlaceGroups groups;
    for (auto& [label, places] : members) groups.push_back(places);
    std::vector<PlaceEdge> edges;
    for (int i = 0; i < 60; ++i) {
      const PlaceId a{1 + draw(40)};
      const PlaceId b{1 + draw(40)};
      if (a < b) edges.push_back({a, b, 0.125 * (1 + draw(8))});
    }
    EXPECT_EQ(absorbSmallGroups(groups, edges, 4), absorbOneByOne(groups, edges, 4)) << round;
  }
}

TEST(RegionIds, OfMergedGroupsAreThatOfTheLarger) {
  RegionIds ids;
  ids.match({{{1}}, {{2}, {3}}});
  EXPECT_EQ(ids.match({{{1}, {2}, {3}}}), (std::vector<RegionId>{{2}}));
}

}  // namespace
}  // namespace tsg::scene_graph
