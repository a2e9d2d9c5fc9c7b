// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/tracking/association.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <tuple>

namespace tsg::tracking {
namespace {

using Pair = std::tuple<std::size_t, std::size_t, double>;

std::vector<Pair> toPairs(const std::vector<Candidate>& candidates) {
  std::vector<Pair> pairs;
  for (const Candidate& c : candidates) pairs.emplace_back(c.segment, c.track, c.iou);
  return pairs;
}

/// Looks through all that is left for the best pair, again and again.
std::vector<Candidate> assignByRescanning(std::vector<Candidate> left) {
  std::vector<Candidate> accepted;
  while (!left.empty()) {
    Candidate best = left.front();
    for (const Candidate& c : left) {
      const bool is_tie = c.iou == best.iou;
      const bool is_older = c.track < best.track;
      const bool is_first = c.track == best.track && c.segment < best.segment;
      if (c.iou > best.iou || (is_tie && (is_older || is_first))) best = c;
    }
    accepted.push_back(best);
    std::vector<Candidate> rest;
    for (const Candidate& c : left) {
      if (c.segment != best.segment && c.track != best.track) rest.push_back(c);
    }
    left = rest;
  }
  return accepted;
}

std::vector<Candidate> makeRandomCandidates(std::mt19937& random) {
  std::uniform_int_distribution<int> tenths(1, 10);  // few values: many ties
  std::bernoulli_distribution is_candidate(0.4);
  std::vector<Candidate> candidates;
  for (std::size_t s = 0; s < 8; ++s) {
    for (std::size_t t = 0; t < 10; ++t) {
      if (is_candidate(random)) candidates.push_back({s, t, tenths(random) / 10.0});
    }
  }
  return candidates;
}

TEST(AssignGreedily, EqualsRepeatedSearchForTheBestPair) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 300; ++trial) {
    const auto candidates = makeRandomCandidates(random);
    ASSERT_EQ(toPairs(assignGreedily(candidates)), toPairs(assignByRescanning(candidates)));
  }
}

TEST(AssignGreedily, DoesNotDependOnTheOrderOfCandidates) {
  std::mt19937 random(6);
  for (int trial = 0; trial < 100; ++trial) {
    auto candidates = makeRandomCandidates(random);
    const auto expected = toPairs(assignGreedily(candidates));
    std::shuffle(candidates.begin(), candidates.end(), random);
    ASSERT_EQ(toPairs(assignGreedily(candidates)), expected);
  }
}

TEST(AssignGreedily, LeavesNoPairThatCouldStillBeAssigned) {
  std::mt19937 random(8);
  for (int trial = 0; trial < 100; ++trial) {
    const auto candidates = makeRandomCandidates(random);
    std::set<std::size_t> segments;
    std::set<std::size_t> tracks;
    for (const Candidate& c : assignGreedily(candidates)) {
      ASSERT_TRUE(segments.insert(c.segment).second);
      ASSERT_TRUE(tracks.insert(c.track).second);
    }
    for (const Candidate& c : candidates) {
      ASSERT_TRUE(segments.count(c.segment) + tracks.count(c.track) > 0);
    }
  }
}

TEST(AssignGreedily, NoCandidatesGiveNoAssignment) { EXPECT_TRUE(assignGreedily({}).empty()); }

}  // namespace
}  // namespace tsg::tracking
