// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/language/word_encoder.h"
#include "task_scene_graph/scene_graph/tasks.h"

namespace tsg::ros_interface {

/// Reads a task file; tasks without embeddings get theirs from the encoder.
/// @throws config::ConfigError and others that name the file and what is missing.
scene_graph::TaskList loadTaskList(const std::string& path, language::WordEncoder& encoder);

/// The tasks of a chain, and what a user should know of them.
struct ChainTasks {
  scene_graph::TaskList objects;
  scene_graph::TaskList places;
  std::vector<std::string> warnings;  ///< one for each file without a task
};

/// Reads both task files. @param place_path  empty: the places' tasks are the objects'
/// @throws as loadTaskList().
ChainTasks loadChainTasks(const std::string& object_path, const std::string& place_path,
                          language::WordEncoder& encoder);

}  // namespace tsg::ros_interface
