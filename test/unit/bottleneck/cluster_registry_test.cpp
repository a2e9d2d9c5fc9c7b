// SPDX-License-Identifier: BSD-3-Clause
#include "bottleneck/cluster_registry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "bottleneck_reference.h"
#include "task_scene_graph/bottleneck/clustering.h"

namespace tsg::bottleneck {
namespace {

// A chain of null primitives: each connected part is one cluster.
class StableIds : public testing::Test {
 protected:
  StableIds() {
    for (NodeKey key = 1; key <= 9; ++key) clustering_.insert(key, Embedding::Ones(2));
    for (NodeKey key = 1; key < 9; ++key) clustering_.insertEdge(key, key + 1);
    whole_ = clustering_.clusterOf(1);
  }
  IncrementalClustering clustering_{ClusteringConfig(), Adjacency::kGiven};
  std::uint64_t whole_ = 0;
};

TEST_F(StableIds, TheLargerPartOfASplitKeepsTheId) {
  clustering_.eraseEdge(3, 4);
  EXPECT_EQ(clustering_.clusterOf(9), whole_);
  EXPECT_NE(clustering_.clusterOf(1), whole_);
}

TEST_F(StableIds, OfEqualPartsTheOneWithTheSmallestKeyKeepsTheId) {
  clustering_.erase(5);
  EXPECT_EQ(clustering_.clusterOf(4), whole_);
  EXPECT_NE(clustering_.clusterOf(6), whole_);
}

TEST_F(StableIds, AUnionKeepsTheIdOfTheLargerPart) {
  clustering_.eraseEdge(3, 4);
  const std::uint64_t small = clustering_.clusterOf(1);
  clustering_.applyChanges();
  clustering_.insertEdge(1, 9);
  EXPECT_EQ(clustering_.clusterOf(1), whole_);
  const ClusteringUpdate update = clustering_.applyChanges();
  EXPECT_EQ(update.removed, (std::vector<std::uint64_t>{small}));
  ASSERT_EQ(update.changed.size(), 1u);
  EXPECT_EQ(update.changed[0].id, whole_);
  EXPECT_EQ(update.changed[0].members.size(), 9u);
}

TEST_F(StableIds, AClusterThatFormsAgainHasItsIdAgain) {
  clustering_.eraseEdge(4, 5);
  const std::uint64_t small = clustering_.clusterOf(1);
  for (int i = 0; i < 5; ++i) {
    clustering_.insertEdge(4, 5);
    EXPECT_EQ(clustering_.clusterOf(1), whole_);
    clustering_.eraseEdge(4, 5);
    EXPECT_EQ(clustering_.clusterOf(1), small);
    EXPECT_EQ(clustering_.clusterOf(9), whole_);
  }
}

TEST_F(StableIds, AnIdNeverGoesToOtherPrimitives) {
  std::set<std::uint64_t> ids{whole_};
  for (NodeKey key = 101; key < 110; ++key) {
    clustering_.insert(key, Embedding::Ones(2));  // in the slot of the one before
    EXPECT_TRUE(ids.insert(clustering_.clusterOf(key)).second);
    clustering_.insertEdge(9, key);
    EXPECT_EQ(clustering_.clusterOf(key), whole_);
    clustering_.erase(key);
  }
}

TEST_F(StableIds, IdsComeBackStepByStepAndAtOnce) {
  const auto ids = [&] {
    std::vector<std::uint64_t> all;
    for (NodeKey key = 1; key <= 9; ++key) all.push_back(clustering_.clusterOf(key));
    return all;
  };
  const std::vector<std::pair<NodeKey, NodeKey>> cuts{{6, 7}, {4, 5}, {2, 3}};
  std::vector<std::vector<std::uint64_t>> finer{ids()};
  for (const auto& [a, b] : cuts) {
    clustering_.eraseEdge(a, b);
    finer.push_back(ids());
  }
  for (std::size_t i = cuts.size(); i-- > 0;) {
    clustering_.insertEdge(cuts[i].first, cuts[i].second);
    EXPECT_EQ(ids(), finer[i]) << i;
  }
  for (const auto& [a, b] : cuts) clustering_.eraseEdge(a, b);
  EXPECT_EQ(ids(), finer.back());
}

TEST(StableIdsOfChangingMaps, AThresholdTurnedThereAndBackGivesTheSameIds) {
  test::SceneOptions options;
  options.num_primitives = 120;
  test::SceneGenerator generator(options, 8);
  IncrementalClustering clustering({}, Adjacency::kBoxOverlap);
  clustering.setTasks(generator.tasks());
  for (NodeKey key = 1; key <= 120; ++key) {
    const test::ReferencePrimitive primitive = generator.makePrimitive();
    clustering.insert(key, primitive.embedding, primitive.box);
  }
  const auto read = [&](double delta) {
    clustering.setDelta(delta);
    std::map<std::uint64_t, std::vector<NodeKey>> clusters;
    for (const Cluster& cluster : clustering.clusters()) clusters[cluster.id] = cluster.members;
    return clusters;
  };
  const auto start = read(1e-5);
  ASSERT_LT(read(0.1).size(), start.size());
  EXPECT_EQ(read(1e-5), start);
  for (const double delta : {1e-4, 1e-3, 1e-2, 0.1, 1.0, 0.1, 1e-2, 1e-3, 1e-4}) read(delta);
  EXPECT_EQ(read(1e-5), start);
}

TEST(StableIdsOfChangingMaps, UpdatesAloneKeepACopyCurrentAndIdsFollowThePrimitives) {
  test::SceneOptions options;
  options.num_primitives = 60;
  test::SceneGenerator generator(options, 6);
  ClusteringConfig config;
  config.delta = 0.01;
  IncrementalClustering clustering(config, Adjacency::kBoxOverlap);
  IncrementalClustering observed(config, Adjacency::kBoxOverlap);
  clustering.setTasks(generator.tasks());
  observed.setTasks(generator.tasks());
  std::map<std::uint64_t, std::vector<NodeKey>> copy;
  for (NodeKey key = 1; key < 150; ++key) {
    const test::ReferencePrimitive primitive = generator.makePrimitive();
    for (IncrementalClustering* each : {&clustering, &observed}) {
      each->insert(key, primitive.embedding, primitive.box);
      if (key > 60) each->erase(key - 60);
    }
    const ClusteringUpdate update = clustering.applyChanges();
    for (const std::uint64_t id : update.removed) copy.erase(id);
    for (const Cluster& cluster : update.changed) copy[cluster.id] = cluster.members;
    std::map<std::uint64_t, std::vector<NodeKey>> expected;
    for (const Cluster& cluster : observed.clusters()) expected[cluster.id] = cluster.members;
    ASSERT_EQ(copy, expected) << "after primitive " << key;
  }
}

// Every old cluster's id is either with the new cluster that holds most of it, or with one of the
// same primitives as one of before that had it, or the cluster that holds most took another.
TEST(StableIdsOfChangingMaps, AnIdGoesToTheLargestShare) {
  test::SceneOptions options;
  options.num_primitives = 60;
  test::SceneGenerator generator(options, 7);
  IncrementalClustering clustering({}, Adjacency::kBoxOverlap);
  clustering.setTasks(generator.tasks());
  for (NodeKey key = 1; key <= 60; ++key) {
    const test::ReferencePrimitive primitive = generator.makePrimitive();
    clustering.insert(key, primitive.embedding, primitive.box);
  }
  std::map<std::vector<NodeKey>, std::set<std::uint64_t>> ids_of;
  for (int step = 0; step < 40; ++step) {
    const std::vector<Cluster> before = clustering.clusters();
    for (const Cluster& cluster : before) ids_of[cluster.members].insert(cluster.id);
    clustering.setDelta(generator.uniform(0.0, 0.1));
    std::map<std::uint64_t, std::vector<NodeKey>> after;
    for (const Cluster& cluster : clustering.clusters()) after[cluster.id] = cluster.members;
    for (const Cluster& former : before) {
      std::map<std::uint64_t, std::size_t> shares;
      for (const NodeKey key : former.members) ++shares[clustering.clusterOf(key)];
      std::size_t largest = 0;
      for (const auto& [id, share] : shares) largest = std::max(largest, share);
      const bool is_back =
          after.count(former.id) > 0 && ids_of[after[former.id]].count(former.id) > 0;
      if (is_back) continue;
      if (shares.count(former.id) > 0) {
        EXPECT_EQ(shares[former.id], largest);
      } else {
        EXPECT_EQ(after.count(former.id), 0u);
      }
    }
  }
}

}  // namespace
}  // namespace tsg::bottleneck
