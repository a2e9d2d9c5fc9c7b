// SPDX-License-Identifier: BSD-3-Clause
#include "bottleneck/cluster_registry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

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

TEST_F(StableIds, IdsAreNeverUsedTwice) {
  std::set<std::uint64_t> ids{whole_};
  for (int i = 0; i < 5; ++i) {
    clustering_.eraseEdge(4, 5);
    EXPECT_TRUE(ids.insert(clustering_.clusterOf(1)).second);
    clustering_.insertEdge(4, 5);
    EXPECT_EQ(clustering_.clusterOf(1), whole_);
  }
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

// Every old cluster's id is either with the new cluster that holds most of it, or that one took the
// id of which it holds more.
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
  for (int step = 0; step < 40; ++step) {
    const std::vector<Cluster> before = clustering.clusters();
    clustering.setDelta(generator.uniform(0.0, 0.1));
    std::map<std::uint64_t, std::vector<NodeKey>> after;
    for (const Cluster& cluster : clustering.clusters()) after[cluster.id] = cluster.members;
    for (const Cluster& former : before) {
      std::map<std::uint64_t, std::size_t> shares;
      for (const NodeKey key : former.members) ++shares[clustering.clusterOf(key)];
      std::size_t largest = 0;
      for (const auto& [id, share] : shares) largest = std::max(largest, share);
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
