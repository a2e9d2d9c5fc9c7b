// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "task_scene_graph/scene_graph/tasks.h"

namespace tsg::ros_interface {

/// Reads a task file; tasks without embeddings get theirs from the text encoder of the model set
/// `models_path` (empty: there is none). @throws config::ConfigError and others that name the file
/// and what is missing.
scene_graph::TaskList loadTaskList(const std::string& path, const std::string& models_path);

}  // namespace tsg::ros_interface
