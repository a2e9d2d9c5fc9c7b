// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/explanations.h"

#include <gtest/gtest.h>

#include "sample_graph.h"
#include "task_scene_graph/scene_graph/builder.h"

namespace tsg::scene_graph {
namespace {

/// Three boxes in a row that overlap, two mugs and a book; a fourth far away, of no use.
class Explanations : public ::testing::Test {
 protected:
  Explanations() : builder_(makeConfig()) {
    TaskList tasks;
    tasks.names = {"mug", "book"};
    tasks.embeddings.resize(2, 3);
    tasks.embeddings << 1, 0, 0, 0, 1, 0;
    builder_.setObjectTasks(tasks);
    builder_.setPlaceTasks(tasks);
    builder_.addPrimitives({makePrimitive(1, {0, 0, 0}, makeEmbedding({1, 0.01F, 0})),
                            makePrimitive(2, {0.5, 0, 0}, makeEmbedding({1, 0.02F, 0})),
                            makePrimitive(3, {1.0, 0, 0}, makeEmbedding({0.01F, 1, 0})),
                            makePrimitive(4, {9, 0, 0}, makeEmbedding({0, 0, 1})),
                            makePrimitive(5, {12, 0, 0}, Embedding())});
    builder_.setPlaces(makePlaces());
  }
  static SceneGraphConfig makeConfig() {
    SceneGraphConfig config;
    config.object_top_k = 1;
    config.object_delta = 1e-3;
    config.place_smoothing_per_m = 0.0;  // so that a place without an embedding is in no region
    return config;
  }
  static void expectContains(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' in: " << text;
  }
  ObjectId objectOf(PrimitiveId id) {
    for (const auto& object : builder_.snapshot()->objects) {
      for (const PrimitiveId member : object.primitives) {
        if (member == id) return object.id;
      }
    }
    return {};
  }
  SceneGraphBuilder builder_;
};

TEST_F(Explanations, AnObjectNamesItsTaskItsMergesAndTheOneThatWasNotMade) {
  const std::string text = builder_.explainObject(objectOf({1}));
  expectContains(text, "serves 'mug': 2 primitives in 1 merge");
  expectContains(text, "merged 1 and 2 (a loss of ");
  expectContains(text, "not merged, for the loss is above 0.001: 1 and 3");
  expectContains(text, "'mug' 1 with 'book' 1");
}

TEST_F(Explanations, APairIsTogetherApartOrNotConnected) {
  expectContains(builder_.explainPrimitives({1}, {2}), "are in one object");
  expectContains(builder_.explainPrimitives({2}, {3}), "are apart; it would take the merge of");
  expectContains(builder_.explainPrimitives({1}, {4}), "apart: no chain of neighbours");
}

TEST_F(Explanations, APrimitiveListsItsCosinesAndWhatItServes) {
  expectContains(builder_.explainPrimitive({3}), "primitive 3: cosines 'book' 1, 'mug' 0.01");
  expectContains(builder_.explainPrimitive({3}), "it counts for 'book' 1");
  expectContains(builder_.explainPrimitive({4}), "below alpha 0.23: it serves no task");
}

TEST_F(Explanations, RegionsAndPlacesHaveTheirs) {
  const RegionId region = builder_.snapshot()->regions.front().id;
  expectContains(builder_.explainRegion(region), "region " + std::to_string(region.value));
  expectContains(builder_.explainPlaces({1}, {2}), "places 1 and 2 are ");
}

TEST_F(Explanations, FollowNewTasks) {
  TaskList tasks;
  tasks.names = {"thing"};
  tasks.embeddings.resize(1, 3);
  tasks.embeddings << 1, 1, 0;
  builder_.setObjectTasks(tasks);
  expectContains(builder_.explainPrimitives({2}, {3}), "are in one object");
}

TEST_F(Explanations, WhatIsNotThereIsNamed) {
  const auto findError = [](const auto& call) -> std::string {
    try {
      call();
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(findError([&] { builder_.explainObject({77}); }), "no object 77 is in the map");
  EXPECT_EQ(findError([&] { builder_.explainRegion({77}); }), "no region 77 is in the map");
  EXPECT_EQ(findError([&] { builder_.explainPrimitive({77}); }), "primitive 77 is not in the map");
  EXPECT_EQ(findError([&] { builder_.explainPrimitives({1}, {5}); }),
            "primitive 5 has no embedding, so it is in no object");
  EXPECT_EQ(findError([&] { builder_.explainPlaces({1}, {7}); }),
            "place 7 has no embedding, so it is in no region");
}

}  // namespace
}  // namespace tsg::scene_graph
