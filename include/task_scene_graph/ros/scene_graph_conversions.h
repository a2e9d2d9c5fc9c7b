// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/scene_graph/scene_graph.h"

namespace tsg::ros_interface {

/// @param with_embeddings  else the embeddings of objects, places and regions are left empty
msg::SceneGraphPtr toMessage(const scene_graph::SceneGraph& graph, const std::string& world_frame,
                             bool with_embeddings);

/// The graph as the message tells it: primitives are ids only, so `primitives` is empty, and
/// `config` is the default one.
scene_graph::SceneGraph fromMessage(const msg::SceneGraph& message);

}  // namespace tsg::ros_interface
