// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "task_scene_graph/core/embedding.h"
#include "task_scene_graph/core/oriented_box.h"
#include "task_scene_graph/core/stamp.h"
#include "task_scene_graph/scene_graph/scene_graph.h"

namespace tsg::scene_graph {

/// One thing of the map that a question may mean.
struct Answer {
  std::uint64_t id = 0;  ///< of the object, primitive, place or region
  std::string task;      ///< that an object or region serves; "" for others and for none
  double score = 0.0;    ///< cosine of its embedding to the question, in [-1, 1]
  double margin = 0.0;   ///< score less that of the next best of its kind; 0 for the last
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< world frame
  OrientedBox box;                                       ///< of objects and primitives; else empty
  ObjectId object;  ///< that a primitive is part of; invalid: it serves no task
  PlaceId place;    ///< nearest place of objects and primitives; a place itself; else invalid
  RegionId region;  ///< that it lies in, or is; invalid: in none
  Stamp last_seen;  ///< of objects and primitives
};

/// What a map has to say to a question, each kind by score, best first; equal scores by id.
struct Answers {
  std::vector<Answer> objects;
  std::vector<Answer> primitives;  ///< also those that serve no task: the map remembers more
  std::vector<Answer> places;
  std::vector<Answer> regions;
};

/// Cosines of a question to everything in a graph, in the order of the graph's lists; NaN for
/// things without an embedding.
struct QuestionScores {
  std::vector<double> objects;
  std::vector<double> primitives;
  std::vector<double> places;
  std::vector<double> regions;
};

/// Compares a question with everything in a graph by cosine.
/// @param question  size D, a direction
/// @throws std::invalid_argument if the question is zero or not finite, or its size is not that of
/// the graph's embeddings (names both). O((primitives + objects + places + regions) D).
QuestionScores scoreQuestion(const SceneGraph& graph, const Embedding& question);

/// What fits best. Things without an embedding are in no answer; what serves no task is.
/// @param scores       of the same graph
/// @param max_answers  of each kind
/// O(primitives + objects + places + regions).
Answers answerQuestion(const SceneGraph& graph, const QuestionScores& scores,
                       std::size_t max_answers);
/// The same for a question that is asked once. @throws and costs what scoreQuestion() does.
Answers answerQuestion(const SceneGraph& graph, const Embedding& question, std::size_t max_answers);

/// True if something answers the question: the best object or primitive reaches object_alpha, or
/// the best region place_alpha. Cosines below say that the thing asked for is not there.
bool isFound(const Answers& answers, const SceneGraphConfig& config);

/// The best answer in words: what, where, score and margin; or that nothing reaches alpha.
std::string describeAnswers(const Answers& answers, const SceneGraph& graph);

}  // namespace tsg::scene_graph
