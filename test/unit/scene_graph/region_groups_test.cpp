// SPDX-License-Identifier: BSD-3-Clause
#include "scene_graph/region_groups.h"

#include <gtest/gtest.h>

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

TEST(RegionIds, AreNotUsedTwice) {
  RegionIds ids;
  ids.match({{{1}}, {{2}}});
  EXPECT_EQ(ids.match({{{2}}}), (std::vector<RegionId>{{2}}));
  EXPECT_EQ(ids.match({{{1}}, {{2}}}), (std::vector<RegionId>{{3}, {2}}));
}

TEST(RegionIds, OfMergedGroupsAreThatOfTheLarger) {
  RegionIds ids;
  ids.match({{{1}}, {{2}, {3}}});
  EXPECT_EQ(ids.match({{{1}, {2}, {3}}}), (std::vector<RegionId>{{2}}));
}

}  // namespace
}  // namespace tsg::scene_graph
