// SPDX-License-Identifier: BSD-3-Clause
#include "bottleneck/agglomeration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>
#include <tuple>

namespace tsg::bottleneck {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

struct RandomProblem {
  std::vector<SparseMasses> relevance;
  std::vector<Edge> edges;

  AgglomerationProblem problem(std::size_t hub_degree) const {
    AgglomerationProblem problem;
    for (const SparseMasses& p : relevance) problem.relevance.push_back(&p);
    problem.edges = edges;
    problem.hub_degree = hub_degree;
    return problem;
  }
};

SparseMasses makeRelevance(std::mt19937& random, double null_share, std::uint32_t num_tasks) {
  std::uniform_real_distribution<double> uniform;
  if (uniform(random) < null_share) return {{0, 1.0}};
  std::map<std::uint32_t, double> masses;
  for (int i = 0; i < 2; ++i) {
    masses[std::uniform_int_distribution<std::uint32_t>(0, num_tasks)(random)] += uniform(random);
  }
  SparseMasses sparse;
  for (const auto& [task, mass] : masses) sparse.push_back({task, mass});
  return toDistribution(sparse);
}

// A random graph: ring-like for small spread, with hubs for large `num_hubs`.
RandomProblem makeProblem(std::uint32_t seed, std::uint32_t count, double null_share,
                          std::uint32_t num_hubs) {
  std::mt19937 random(seed);
  RandomProblem problem;
  for (std::uint32_t i = 0; i < count; ++i) {
    const bool is_copy = i > 0 && random() % 4 == 0;
    problem.relevance.push_back(is_copy ? problem.relevance[random() % i]
                                        : makeRelevance(random, null_share, 6));
  }
  std::set<Edge> edges;
  const auto add = [&](std::uint32_t a, std::uint32_t b) {
    if (a != b) edges.insert(std::minmax(a, b));
  };
  for (std::uint32_t i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k)
      add(i, std::min(count - 1, i + 1 + static_cast<unsigned>(random() % 9)));
    for (std::uint32_t h = 0; h < num_hubs; ++h) {
      if (random() % 3 == 0) add(i, h * (count / num_hubs));
    }
  }
  problem.edges.assign(edges.begin(), edges.end());
  return problem;
}

// Prices every edge at every merge.
MergeTape agglomerateNaively(const RandomProblem& problem) {
  std::vector<SparseMasses> masses = problem.relevance;
  std::vector<double> counts(masses.size(), 1.0);
  std::set<Edge> edges(problem.edges.begin(), problem.edges.end());
  MergeTape tape;
  while (!edges.empty()) {
    std::tuple<std::int64_t, std::uint32_t, std::uint32_t> best{INT64_MAX, 0, 0};
    for (const auto& [a, b] : edges) {
      const double cost = computeMergeCost(masses[a], counts[a], masses[b], counts[b]);
      best = std::min(best, std::make_tuple(roundCost(cost), a, b));
    }
    const auto [cost, a, b] = best;
    tape.push_back({a, b, cost});
    masses[a] = addMasses(masses[a], masses[b]);
    counts[a] += counts[b];
    std::set<Edge> moved;
    for (Edge edge : edges) {
      if (edge.first == b) edge.first = a;
      if (edge.second == b) edge.second = a;
      if (edge.first != edge.second) moved.insert(std::minmax(edge.first, edge.second));
    }
    edges = std::move(moved);
  }
  return tape;
}

// The first merge in which two tapes differ, in words; "" if none.
std::string findDifference(const MergeTape& tape, const MergeTape& expected) {
  const auto describe = [](const MergeTape& steps, std::size_t i) {
    if (i >= steps.size()) return std::string("nothing");
    return "(" + std::to_string(steps[i].a) + ", " + std::to_string(steps[i].b) + ") for " +
           std::to_string(steps[i].cost);
  };
  for (std::size_t i = 0; i < std::max(tape.size(), expected.size()); ++i) {
    const std::string ours = describe(tape, i);
    const std::string theirs = describe(expected, i);
    if (ours != theirs) return "merge " + std::to_string(i) + ": " + ours + ", expected " + theirs;
  }
  return "";
}

class HubDegrees : public testing::TestWithParam<std::size_t> {};

TEST_P(HubDegrees, TapeIsTheOneThatPricingEveryEdgeGives) {
  for (std::uint32_t seed = 0; seed < 60; ++seed) {
    const double null_share = 0.3 * (seed % 4);
    const RandomProblem problem = makeProblem(seed, 20 + 3 * seed, null_share, seed % 5);
    const MergeTape expected = agglomerateNaively(problem);
    ASSERT_EQ(findDifference(agglomerate(problem.problem(GetParam())), expected), "")
        << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Agglomeration, HubDegrees, testing::Values(0, 1, 3, 8, 20, 1000000));

TEST(Agglomeration, TapeOfPrimitivesThatAreAlikeIsTheSameToo) {
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    RandomProblem problem = makeProblem(seed, 3 + 3 * seed, 0.0, seed % 3);
    const SparseMasses common = problem.relevance.back();
    for (SparseMasses& relevance : problem.relevance) relevance = common;
    std::mt19937 random(seed);  // some edges less: parts of their own
    const auto isDropped = [&](const Edge&) { return random() % 3 == 0; };
    if (seed % 2 == 0) {
      problem.edges.erase(std::remove_if(problem.edges.begin(), problem.edges.end(), isDropped),
                          problem.edges.end());
      std::shuffle(problem.edges.begin(), problem.edges.end(), random);
    }
    ASSERT_TRUE(areAlike(problem.problem(64)));
    const MergeTape tape = agglomerate(problem.problem(64));
    ASSERT_EQ(findDifference(tape, agglomerateNaively(problem)), "") << "seed " << seed;
    problem.relevance.front() = {{7, 1.0}};
    ASSERT_FALSE(areAlike(problem.problem(64)));
  }
}

TEST(Agglomeration, LargeGraphsDoNotDependOnTheHubDegree) {
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    const RandomProblem problem = makeProblem(seed, 3000, 0.4, 4);
    const MergeTape eager = agglomerate(problem.problem(1000000));
    EXPECT_EQ(eager.size(), 2999u);
    EXPECT_EQ(findDifference(agglomerate(problem.problem(64)), eager), "");
    EXPECT_EQ(findDifference(agglomerate(problem.problem(4)), eager), "");
  }
}

// A problem with some primitives erased, some of other relevance, some new, some edges changed.
struct ChangedProblem {
  RandomProblem present;
  FormerRun former;
};

ChangedProblem change(const RandomProblem& problem, int num_changes, std::mt19937& random) {
  const auto count = static_cast<std::uint32_t>(problem.relevance.size());
  std::vector<SparseMasses> relevance = problem.relevance;
  std::vector<bool> is_gone(count, false);
  std::vector<bool> is_changed(count, false);
  std::set<Edge> edges(problem.edges.begin(), problem.edges.end());
  std::vector<std::vector<std::uint32_t>> inserted(count +
                                                   1);  // before which former one: neighbours
  for (int i = 0; i < num_changes; ++i) {
    const auto x = static_cast<std::uint32_t>(random() % count);
    const auto y = static_cast<std::uint32_t>(random() % count);
    switch (random() % 5) {
      case 0:
        is_gone[x] = true;
        break;
      case 1:
        relevance[x] = makeRelevance(random, 0.3, 6);
        is_changed[x] = true;
        break;
      case 2:
        if (x != y) {
          const Edge edge = std::minmax(x, y);
          if (edges.erase(edge) == 0) edges.insert(edge);
          is_changed[x] = true;
        }
        break;
      default:
        for (int k = 0; k < 4; ++k) {
          const auto near = y + static_cast<std::uint32_t>(random() % 9);
          inserted[x].push_back(std::min(count - 1, near));
        }
    }
  }
  ChangedProblem changed;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> links;  // present, former
  for (std::uint32_t i = 0; i <= count; ++i) {
    if (!inserted[i].empty()) {
      for (const std::uint32_t former : inserted[i]) {
        links.emplace_back(static_cast<std::uint32_t>(changed.present.relevance.size()), former);
      }
      changed.present.relevance.push_back(makeRelevance(random, 0.3, 6));
      changed.former.is_changed.push_back(true);
    }
    if (i == count) break;
    const auto index = static_cast<std::uint32_t>(changed.present.relevance.size());
    changed.former.index_of.push_back(is_gone[i] ? FormerRun::kGone : index);
    if (is_gone[i]) continue;
    changed.present.relevance.push_back(relevance[i]);
    changed.former.is_changed.push_back(is_changed[i]);
  }
  std::set<Edge> present;
  const auto& index_of = changed.former.index_of;
  for (const auto& [a, b] : edges) {
    if (!is_gone[a] && !is_gone[b]) present.emplace(index_of[a], index_of[b]);
  }
  for (const auto& [x, former] : links) {
    if (!is_gone[former]) present.insert(std::minmax(x, index_of[former]));
  }
  changed.present.edges.assign(present.begin(), present.end());
  return changed;
}

TEST_P(HubDegrees, FollowingAFormerRunGivesTheTapeOfAFreshOne) {
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    const RandomProblem problem = makeProblem(seed, 10 + seed % 150, 0.3 * (seed % 4), seed % 5);
    ChangedProblem changed = change(problem, static_cast<int>(seed % 7), random);
    changed.former.tape = agglomerate(problem.problem(GetParam()));
    const MergeTape fresh = agglomerate(changed.present.problem(1000000));
    ASSERT_EQ(
        findDifference(reagglomerate(changed.present.problem(GetParam()), changed.former), fresh),
        "")
        << "seed " << seed;
  }
}

TEST(Agglomeration, FollowingAFormerRunOfALargeGraphGivesTheTapeOfAFreshOne) {
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    std::mt19937 random(seed);
    const RandomProblem problem = makeProblem(seed, 3000, 0.4, 4);
    ChangedProblem changed = change(problem, 3, random);
    changed.former.tape = agglomerate(problem.problem(64));
    EXPECT_EQ(findDifference(reagglomerate(changed.present.problem(64), changed.former),
                             agglomerate(changed.present.problem(64))),
              "");
  }
}

TEST(Agglomeration, ThousandsOfZeroCostTiesAreMergedInOrderOfIds) {
  RandomProblem problem;
  problem.relevance.assign(5000, {{0, 1.0}});
  for (std::uint32_t i = 0; i + 1 < 5000; ++i) problem.edges.emplace_back(i, i + 1);
  for (std::uint32_t i = 2; i < 5000; ++i) problem.edges.emplace_back(0, i);
  const MergeTape tape = agglomerate(problem.problem(64));
  ASSERT_EQ(tape.size(), 4999u);
  for (std::uint32_t i = 0; i < tape.size(); ++i) {
    ASSERT_EQ(tape[i], (MergeStep{0, i + 1, 0}));
  }
}

TEST(Agglomeration, NothingToMergeGivesAnEmptyTape) {
  EXPECT_TRUE(agglomerate({}).empty());
  RandomProblem problem;
  problem.relevance.assign(3, {{1, 1.0}});
  EXPECT_TRUE(agglomerate(problem.problem(64)).empty());
}

}  // namespace
}  // namespace tsg::bottleneck
