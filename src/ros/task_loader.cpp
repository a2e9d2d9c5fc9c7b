// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/task_loader.h"

namespace tsg::ros_interface {

scene_graph::TaskList loadTaskList(const std::string& path, language::WordEncoder& encoder) {
  scene_graph::TaskList tasks = scene_graph::loadTasks(path);
  scene_graph::checkUsable(tasks, path, encoder.canEncode(), encoder.embeddingSize());
  if (!tasks.hasEmbeddings() && tasks.size() > 0) tasks.embeddings = encoder.encode(tasks.names);
  return tasks;
}

ChainTasks loadChainTasks(const std::string& object_path, const std::string& place_path,
                          language::WordEncoder& encoder) {
  ChainTasks tasks;
  const auto warn = [&](const std::string& path, const std::string& consequence) {
    tasks.warnings.push_back("task file '" + path + "' holds no task: " + consequence);
  };
  tasks.objects = loadTaskList(object_path, encoder);
  tasks.places = place_path.empty() ? tasks.objects : loadTaskList(place_path, encoder);
  const bool has_own_places = !place_path.empty();
  if (tasks.objects.size() == 0) {
    warn(object_path, has_own_places ? "there will be no objects"
                                     : "there will be no objects, and regions will have no names");
  }
  if (has_own_places && tasks.places.size() == 0) warn(place_path, "regions will have no names");
  return tasks;
}

}  // namespace tsg::ros_interface
