// SPDX-License-Identifier: BSD-3-Clause
#include "saved_map_stage.h"

#include "mesh_points.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/map/settings.h"
#include "task_scene_graph/ros/settings_conversions.h"

namespace tsg::nodelets {
namespace {

NavigationStage::Options makeNavigationOptions(const map::Map& map,
                                               const std::filesystem::path& folder) {
  return {map::readSettings<planning::PlannerConfig>(folder, "mesh_fusion", "planner"),
          map.worldFrame()};
}

}  // namespace

SavedMapStage::SavedMapStage(ros::NodeHandle& handle, const map::Map& map,
                             const std::filesystem::path& folder,
                             std::shared_ptr<language::WordEncoder> encoder,
                             ros_interface::StageReport& report)
    : map_(map),
      stage_(handle, "scene_graph"),
      builder_(map.settings().scene_graph, map.worldFrame()),
      tuned_{map.settings().scene_graph,
             map::readSettings<ros_interface::MarkerConfig>(folder, "scene_graph", "markers")},
      publisher_(handle, report, {map.worldFrame(), false, tuned_.markers}),
      navigation_(handle, makeNavigationOptions(map, folder), report),
      spinner_(1, &queue_) {
  builder_.setObjectTasks(map.objectTasks());
  builder_.setPlaceTasks(map.placeTasks());
  map::restoreBuilder(map, builder_);
  navigation_.setMap(*map.places(), map.placeMemory()->plan);
  const auto& poses = map.trajectory()->poses();
  if (!poses.empty()) navigation_.setCamera(poses.rbegin()->second.translation());
  stage_.setCallbackQueue(&queue_);
  settings_publisher_ = {stage_, "settings"};
  startServices(encoder);
  tunables_ = serveTunables(
      stage_, tuned_, [this](const TunedConfig& config) { tune(config); }, report);
  publish();
  publishSettings();
  spinner_.start();
}

SavedMapStage::~SavedMapStage() {
  spinner_.stop();
  navigation_.stop();
}

void SavedMapStage::startServices(const std::shared_ptr<language::WordEncoder>& encoder) {
  const GraphAccess access{[this] { return graph(); },
                           [this](const GraphAccess::Job& job) {
                             const std::lock_guard<std::mutex> lock(mutex_);
                             job(builder_);
                             publish();
                           },
                           [](const std::string&) { return std::vector<std::string>(); },
                           [this](const std::map<PrimitiveId, std::int32_t>& object_of_primitive) {
                             return makeMeshPoints(map_, object_of_primitive);
                           }};
  tasks_ = std::make_unique<TaskServices>(stage_, access, encoder, TaskServices::Files{});
  questions_ = std::make_unique<QuestionServices>(stage_, access, encoder);
}

void SavedMapStage::tune(const TunedConfig& config) {
  const std::lock_guard<std::mutex> lock(mutex_);
  tuned_ = config;
  builder_.setConfig(tuned_.graph);
  publisher_.setMarkerConfig(tuned_.markers, tasks_->numbers());
  publish();
  publishSettings();
}

scene_graph::SceneGraphPtr SavedMapStage::graph() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return graph_;
}

void SavedMapStage::publish() {
  const scene_graph::SceneGraphPtr newest = builder_.snapshot();
  if (newest == graph_) return;
  graph_ = newest;
  publisher_.publish(newest, tasks_->numbers());
  tasks_->publish(*newest);
}

void SavedMapStage::publishSettings() {
  config::StageSettings settings{"scene_graph", config::listSettings(tuned_.graph, {})};
  settings_publisher_.publish(ros_interface::toMessage(settings));
}

}  // namespace tsg::nodelets
