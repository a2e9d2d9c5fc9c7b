// SPDX-License-Identifier: BSD-3-Clause
// Published cases of whole runs. Those of entropies and divergences are in distribution_test, of
// mutual information in information_test, of p(y|x) and its update in relevance_test, of boxes in
// box_index_test. What differs here throughout, by convention:
// - Zeros are zeros where the published code fills in 1e-12; and D is rounded to 9 decimals.
// - Equal scores and equal costs go to the smaller index; the published code leaves them to sorting
//   and rounding. The tests that this changes say so.
// - A zero embedding is rejected with its id where published metrics score it 0; of the metrics
// only
//   the cosine is there.
// - Nodes without an embedding are no primitives: an edge to one is an error, not ignored.
// - There is no weight of a component (0 of no nodes, 1 of all): costs count masses in primitives
// of
//   the whole graph, so the weight |X_c| / |X| of Appendix B is in them
//   (Seeds.DeltaOfAComponentIsThatOfAppendixB).
#include <gtest/gtest.h>

#include "clustering_fixtures.h"

namespace tsg::bottleneck {
namespace {

void expectMerges(IncrementalClustering& clustering, const std::vector<Merge>& expected,
                  double tolerance) {
  clustering.setDelta(1.0);
  const std::vector<Merge> merges = clustering.mergeSequence();
  ASSERT_EQ(merges.size(), expected.size());
  for (std::size_t i = 0; i < merges.size(); ++i) {
    EXPECT_EQ(merges[i].a, expected[i].a);
    EXPECT_EQ(merges[i].b, expected[i].b);
    EXPECT_NEAR(merges[i].d, expected[i].d, tolerance);
  }
}

double marginalInformation(IncrementalClustering& clustering) {
  ClusteringConfig config = clustering.config();
  config.prior = Prior::kMarginal;
  clustering.setConfig(config);
  return clustering.information();
}

const std::vector<std::vector<float>> kOneHot{
    {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}, {0, 0, 0}};
const std::vector<test::KeyPair> kChain{{0, 1}, {1, 2}, {2, 3}, {3, 4}};

// The published code fills zeros with 1e-12; that, and d rounded to 9 decimals of N d, is the
// tolerance.
TEST(PublishedRuns, ChainWithAlphaOne) {
  auto clustering = makeFromScores(kOneHot, kChain, makePublishedConfig(1.0, 100, false, false));
  EXPECT_NEAR(clustering.information(), 1.4, 1e-9);
  expectMerges(
      clustering,
      {{3, 4, 0.0, 0}, {2, 3, 0.190013452989, 0}, {0, 1, 0.2, 0}, {0, 2, 0.366766196460, 0}}, 1e-9);
  EXPECT_NEAR(marginalInformation(clustering), 0.756780, 1e-6);
}

// Differs from the published order: ({0, 1}, 2) and (2, {3, 4}) share no task and are of equal
// size, so they cost the same; published is (2, 3), here the smaller id goes first.
TEST(PublishedRuns, ChainWithTopOneAndTheTieGoingToTheSmallerId) {
  auto clustering = makeFromScores(kOneHot, kChain, makePublishedConfig(0.9, 1, false, false));
  EXPECT_NEAR(clustering.information(), 2.0, 1e-9);
  expectMerges(
      clustering,
      {{3, 4, 0.0, 0}, {0, 1, 0.4, 0}, {0, 2, 0.550977500431, 0}, {0, 3, 0.970950594454, 0}}, 1e-9);
  EXPECT_NEAR(marginalInformation(clustering), 1.921928, 1e-6);
}

TEST(PublishedRuns, RingOfSixByHand) {
  const std::vector<std::vector<float>> scores{{.30f, .22f, .20f}, {.29f, .21f, .24f},
                                               {.20f, .31f, .22f}, {.21f, .30f, .25f},
                                               {.18f, .19f, .17f}, {.26f, .27f, .20f}};
  const std::vector<test::KeyPair> ring{{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {0, 5}};
  auto clustering = makeFromScores(scores, ring, {});
  EXPECT_NEAR(clustering.information(), 1.275055453586, 1e-6);  // scores are floats here
  expectMerges(clustering,
               {{2, 3, .094164023133, 0},
                {0, 1, .094985617376, 0},
                {0, 5, .256935356946, 0},
                {2, 4, .300936749040, 0},
                {0, 2, .409282672630, 0}},
               1e-6);
  clustering.setDelta(0.1);
  EXPECT_EQ(partitionOf(clustering), (Partition{{0, 1}, {2, 3}, {4}, {5}}));
  clustering.setDelta(0.01);
  EXPECT_EQ(clustering.clusters().size(), 6u);
  clustering.setDelta(1.0);
  double lost = 0.0;
  for (const Merge& merge : clustering.mergeSequence()) lost += merge.d;
  EXPECT_NEAR(lost, 1.156304419119, 1e-6);
  EXPECT_NEAR(marginalInformation(clustering), 1.156304419119, 1e-6);
}

// Published workspace case: primitives 0, 2, 4, 6, 8 in a chain, merged as (2, 4), (8, 6), (0, 2),
// (6, 0). A pair is named with the smaller first here.
TEST(PublishedRuns, WorkspaceOfAChainGivesThePublishedAssignments) {
  // 2 and 4 are equal, 6 and 8 nearly, 0 is nearer to 2 than 4 is to 6.
  const std::vector<std::vector<float>> scores{
      {.6f, .3f}, {.5f, .4f}, {.5f, .4f}, {.1f, .7f}, {.11f, .7f}};
  const std::vector<test::KeyPair> chain{{0, 1}, {1, 2}, {2, 3}, {3, 4}};
  auto clustering = makeFromScores(scores, chain, makePublishedConfig(0.05, 100, false, false));
  clustering.setDelta(1.0);
  const std::vector<Merge> merges = clustering.mergeSequence();
  const std::vector<test::KeyPair> expected{{1, 2}, {3, 4}, {0, 1}, {0, 3}};
  const std::vector<Partition> assignments{{{0}, {1}, {2}, {3}, {4}},
                                           {{0}, {1, 2}, {3}, {4}},
                                           {{0}, {1, 2}, {3, 4}},
                                           {{0, 1, 2}, {3, 4}}};
  ASSERT_EQ(merges.size(), expected.size());
  for (std::size_t i = 0; i < merges.size(); ++i) {
    EXPECT_EQ(test::KeyPair(merges[i].a, merges[i].b), expected[i]);
    clustering.setDelta(merges[i].delta);  // the first that is not accepted
    EXPECT_EQ(partitionOf(clustering), assignments[i]);
  }
  clustering.setDelta(1.0);
  EXPECT_EQ(partitionOf(clustering), (Partition{{0, 1, 2, 3, 4}}));
}

TEST(PublishedRuns, MergesAlongAChainKeepTheNeighboursOfBoth) {
  IncrementalClustering clustering({}, Adjacency::kGiven);
  for (const NodeKey key : {0, 2, 4, 6, 8}) clustering.insert(key, Embedding::Ones(3));
  for (const NodeKey key : {0, 2, 4, 6}) clustering.insertEdge(key, key + 2);
  const std::vector<Merge> merges = clustering.mergeSequence();
  ASSERT_EQ(merges.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(merges[i].a, 0u);
    EXPECT_EQ(merges[i].b, 2 * i + 2);
  }
}

}  // namespace
}  // namespace tsg::bottleneck
