// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/task_loader.h"

#include "task_scene_graph/language/text_encoder.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace tsg::ros_interface {

scene_graph::TaskList loadTaskList(const std::string& path, const std::string& models_path) {
  scene_graph::TaskList tasks = scene_graph::loadTasks(path);
  segmentation::ModelSet models;
  if (!models_path.empty()) models = segmentation::loadModelSet(models_path);
  const bool has_text_encoder = !models.text_encoder.empty();
  scene_graph::checkUsable(tasks, path, has_text_encoder,
                           models_path.empty() ? 0 : models.embedding_size);
  if (!tasks.hasEmbeddings() && tasks.size() > 0) {
    tasks.embeddings = language::TextEncoder(models, {}).encodeTasks(tasks.names);
  }
  return tasks;
}

ChainTasks loadChainTasks(const std::string& object_path, const std::string& place_path,
                          const std::string& models_path) {
  ChainTasks tasks;
  const auto warn = [&](const std::string& path, const std::string& consequence) {
    tasks.warnings.push_back("task file '" + path + "' holds no task: " + consequence);
  };
  tasks.objects = loadTaskList(object_path, models_path);
  tasks.places = place_path.empty() ? tasks.objects : loadTaskList(place_path, models_path);
  const bool has_own_places = !place_path.empty();
  if (tasks.objects.size() == 0) {
    warn(object_path, has_own_places ? "there will be no objects"
                                     : "there will be no objects, and regions will have no names");
  }
  if (has_own_places && tasks.places.size() == 0) warn(place_path, "regions will have no names");
  return tasks;
}

}  // namespace tsg::ros_interface
