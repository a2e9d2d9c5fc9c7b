// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <cstddef>
#include <string>

#include "task_scene_graph/scene_graph/questions.h"
#include "task_scene_graph/scene_graph/scene_graph.h"

namespace tsg::ros_interface {

// A million dots would take seconds to send and to draw; so many show where it is warm.
constexpr std::size_t kMaxQuestionBoxes = 200;
constexpr std::size_t kNumQuestionLabels = 5;

/// How well everything in the map fits a question, as colours from blue (least) to red (best):
/// namespaces question_objects (boxes), question_primitives (boxes of the kMaxQuestionBoxes best
/// that are part of no object), question_others (a dot for each other primitive), question_labels
/// (scores of the kNumQuestionLabels best) and question_legend (what was asked, and what blue and
/// red mean). First all of the question before is deleted. O(n log n).
/// @param scores  of the same graph
/// @param asked   words, for the legend; empty: asked otherwise
visualization_msgs::MarkerArray makeQuestionMarkers(const scene_graph::SceneGraph& graph,
                                                    const scene_graph::QuestionScores& scores,
                                                    const std::string& asked);

}  // namespace tsg::ros_interface
