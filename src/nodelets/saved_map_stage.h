// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <filesystem>
#include <memory>
#include <mutex>

#include "graph_access.h"
#include "graph_tunables.h"
#include "navigation_stage.h"
#include "question_services.h"
#include "task_scene_graph/language/word_encoder.h"
#include "task_scene_graph/map/map.h"
#include "task_scene_graph/ros/scene_graph_publisher.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/state_publisher.h"
#include "task_services.h"

namespace tsg::nodelets {

/// A saved map as the scene graph stage of a running chain would show it: the graph and its
/// markers, tasks, questions, paths and sliders, with the same names. Nothing is mapped.
class SavedMapStage {
 public:
  /// @param handle   of the chain's namespace; the stage's own names lie in `scene_graph` below it
  /// @param folder   that the map was loaded from: its settings
  /// @param encoder  of the map's model set, or one without any
  /// @param report   must outlive this object
  /// @throws config::ConfigError, std::runtime_error naming what of the folder is wrong.
  SavedMapStage(ros::NodeHandle& handle, const map::Map& map, const std::filesystem::path& folder,
                std::shared_ptr<language::WordEncoder> encoder, ros_interface::StageReport& report);
  ~SavedMapStage();

 private:
  void startServices(const std::shared_ptr<language::WordEncoder>& encoder);
  void tune(const TunedConfig& config);
  scene_graph::SceneGraphPtr graph();
  void publish();          ///< with the lock held
  void publishSettings();  ///< likewise

  const map::Map map_;  ///< as it was loaded: its mesh
  ros::NodeHandle stage_;
  ros::CallbackQueue queue_;  ///< of the services, in a thread of their own
  std::mutex mutex_;          ///< guards the four below
  scene_graph::SceneGraphBuilder builder_;
  scene_graph::SceneGraphPtr graph_;
  TunedConfig tuned_;
  ros_interface::SceneGraphPublisher publisher_;
  ros_interface::StatePublisher<msg::StageSettings> settings_publisher_;
  NavigationStage navigation_;
  std::unique_ptr<TaskServices> tasks_;
  std::unique_ptr<QuestionServices> questions_;
  std::unique_ptr<TunablesServer> tunables_;
  ros::AsyncSpinner spinner_;
};

}  // namespace tsg::nodelets
