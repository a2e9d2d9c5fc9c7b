// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/questions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "sample_graph.h"

namespace tsg::scene_graph {
namespace {

const Embedding kFirstAxis = makeEmbedding({1, 0, 0});

std::vector<std::uint64_t> listIds(const std::vector<Answer>& answers) {
  std::vector<std::uint64_t> ids;
  for (const auto& answer : answers) ids.push_back(answer.id);
  return ids;
}

TEST(Question, IsAnsweredByCosineBestFirst) {
  const SceneGraph graph = makeSampleGraph();
  const Answers answers = answerQuestion(graph, kFirstAxis, 10);
  EXPECT_EQ(listIds(answers.objects), (std::vector<std::uint64_t>{5, 6, 8}));
  EXPECT_EQ(listIds(answers.primitives), (std::vector<std::uint64_t>{1, 2, 3}));
  EXPECT_EQ(listIds(answers.places), (std::vector<std::uint64_t>{4, 2, 1}));
  EXPECT_EQ(listIds(answers.regions), (std::vector<std::uint64_t>{11, 2}));
  for (const auto& primitive : graph.primitives) {
    const auto answer = std::find_if(answers.primitives.begin(), answers.primitives.end(),
                                     [&](const Answer& a) { return a.id == primitive->id.value; });
    if (answer == answers.primitives.end()) continue;
    EXPECT_NEAR(answer->score,
                static_cast<double>(primitive->embedding.normalized().dot(kFirstAxis)), 1e-6);
  }
}

TEST(Question, TheMarginIsToTheNextBestAlsoWhereThatIsCutOff) {
  const Answers all = answerQuestion(makeSampleGraph(), kFirstAxis, 10);
  const Answers one = answerQuestion(makeSampleGraph(), kFirstAxis, 1);
  ASSERT_EQ(one.objects.size(), 1U);
  EXPECT_EQ(one.objects[0].margin, all.objects[0].score - all.objects[1].score);
  EXPECT_GT(one.objects[0].margin, 0.0);
  EXPECT_EQ(all.objects.back().margin, 0.0);
}

TEST(Question, AnswersSayWhereThingsAre) {
  const SceneGraph graph = makeSampleGraph();
  const Answers answers = answerQuestion(graph, kFirstAxis, 10);
  const Answer& object = answers.objects[0];
  EXPECT_EQ(object.task, graph.object_tasks[0]);
  EXPECT_EQ(object.position_m, graph.objects[0].position_m);
  EXPECT_EQ(object.box.yaw_rad, 0.25);
  EXPECT_EQ(object.place, PlaceId{1});
  EXPECT_EQ(object.region, RegionId{2});
  EXPECT_EQ(object.last_seen, graph.objects[0].last_seen);
  const Answer& primitive = answers.primitives[0];
  EXPECT_EQ(primitive.object, ObjectId{5});
  EXPECT_EQ(primitive.place, PlaceId{1});
  EXPECT_FALSE(answers.objects[1].region.isValid()) << "its place is in no region";
  EXPECT_EQ(answers.places[0].region, RegionId{11});
}

TEST(Question, PrimitivesThatServeNoTaskAnswerToo) {
  SceneGraph graph = makeSampleGraph();
  graph.objects.clear();
  const Answers answers = answerQuestion(graph, kFirstAxis, 10);
  EXPECT_EQ(answers.primitives.size(), 3U);
  EXPECT_FALSE(answers.primitives[0].object.isValid());
}

TEST(Question, ThatIsNoDirectionOrOfAnotherSizeIsRefused) {
  const SceneGraph graph = makeSampleGraph();
  EXPECT_THROW(answerQuestion(graph, Embedding(), 5), std::invalid_argument);
  EXPECT_THROW(answerQuestion(graph, makeEmbedding({0, 0, 0}), 5), std::invalid_argument);
  EXPECT_THROW(
      answerQuestion(graph, makeEmbedding({1, std::numeric_limits<float>::infinity(), 0}), 5),
      std::invalid_argument);
  try {
    answerQuestion(graph, makeEmbedding({1, 0}), 5);
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(),
                 "question has an embedding of 2 numbers, expected 3 as those of the map have");
  }
}

TEST(Question, AnEmptyMapHasNoAnswer) {
  SceneGraph graph;
  graph.places = std::make_shared<PlaceGraph>();
  const Answers answers = answerQuestion(graph, kFirstAxis, 5);
  EXPECT_TRUE(answers.objects.empty() && answers.primitives.empty() && answers.places.empty() &&
              answers.regions.empty());
  EXPECT_FALSE(isFound(answers, graph.config));
  EXPECT_EQ(describeAnswers(answers, graph), "nothing with an embedding is in the map");
}

TEST(Question, WhatScoresBelowAlphaIsNotFound) {
  SceneGraph graph = makeSampleGraph();
  graph.config.object_alpha = 0.99;
  graph.config.place_alpha = 0.99;
  const Answers far = answerQuestion(graph, makeEmbedding({0.4F, 0.4F, 0.8F}), 5);
  EXPECT_FALSE(isFound(far, graph.config));
  EXPECT_NE(describeAnswers(far, graph).find("below alpha 0.990"), std::string::npos);
  graph.config.object_alpha = 0.1;
  const Answers near = answerQuestion(graph, kFirstAxis, 5);
  EXPECT_TRUE(isFound(near, graph.config));
  const std::string text = describeAnswers(near, graph);
  EXPECT_NE(
      text.find("object 5 (wash the \"dishes\") at (0.75, 0.50, 0.50) m in region 2 (kitchen)"),
      std::string::npos)
      << text;
}

}  // namespace
}  // namespace tsg::scene_graph
