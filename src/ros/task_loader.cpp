// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/task_loader.h"

#include "task_scene_graph/segmentation/model_set.h"

namespace task_scene_graph::ros_interface {

scene_graph::TaskList loadTaskList(const std::string& path, const std::string& models_path) {
  scene_graph::TaskList tasks = scene_graph::loadTasks(path);
  const int embedding_size =
      models_path.empty() ? 0 : segmentation::loadModelSet(models_path).embedding_size;
  scene_graph::checkUsable(tasks, path, false, embedding_size);
  return tasks;
}

}  // namespace task_scene_graph::ros_interface
