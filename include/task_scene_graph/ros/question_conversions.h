// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/scene_graph/questions.h"

namespace tsg::ros_interface {

/// Answers as the service `ask` gives them, without `success` and `message`.
/// @param graph  that they are of
msg::AskResponse toMessage(const scene_graph::Answers& answers,
                           const scene_graph::SceneGraph& graph, bool with_thumbnails);

}  // namespace tsg::ros_interface
