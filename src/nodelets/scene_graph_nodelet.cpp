// SPDX-License-Identifier: BSD-3-Clause
#include <dynamic_reconfigure/server.h>
#include <std_srvs/Trigger.h>
#include <task_scene_graph/SceneGraphConfig.h>
#include <visualization_msgs/MarkerArray.h>

#include <filesystem>
#include <functional>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>

#include "scene_graph_config.h"
#include "stage_nodelet.h"
#include "task_scene_graph/ros/arrivals.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/run_nodelets.h"
#include "task_scene_graph/ros/scene_graph_conversions.h"
#include "task_scene_graph/ros/scene_graph_markers.h"
#include "task_scene_graph/ros/task_loader.h"
#include "task_scene_graph/ros/topic_watch.h"
#include "task_scene_graph/ros/worker.h"
#include "task_scene_graph/scene_graph/builder.h"
#include "task_scene_graph/scene_graph/files.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace tsg::nodelets {

using Tunables = ::task_scene_graph::SceneGraphConfig;  // generated from cfg/SceneGraph.cfg

/// Primitives, places and tasks -> the scene graph, its markers and its files.
class SceneGraphNodelet : public StageNodelet {
 public:
  ~SceneGraphNodelet() override;

 private:
  using Job = std::function<void(scene_graph::SceneGraphBuilder&)>;

  void start() override;
  /// The model set suggests object_alpha where the user gives none.
  void adoptAlphaOfModels();
  void startTopics();
  void check() override { watch_->check(); }
  msg::FinishResponse finish(const msg::FinishRequest& request, Deadline deadline) override;

  void onPrimitives(const msg::ObjectPrimitivesConstPtr& message);
  void onPlaces(const msg::PlaceGraphConstPtr& message);
  void onTunables(const Tunables& tunables);
  void process(const Job& job);
  void publish(const scene_graph::SceneGraphPtr& graph);
  bool saveMap(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  std::vector<std::string> finishChain();
  void saveUpstreamMesh(std::vector<std::string>& problems);
  void writeFiles();

  SceneGraphNodeletConfig config_;
  std::unique_ptr<scene_graph::SceneGraphBuilder> builder_;  ///< the worker's own
  std::unique_ptr<ros_interface::SceneGraphMarkers> markers_;
  std::mutex graph_mutex_;
  scene_graph::SceneGraphPtr graph_;
  ros_interface::Arrivals primitives_;
  ros_interface::Arrivals places_;
  ros::Publisher graph_publisher_;
  ros::Publisher marker_publisher_;
  ros::ServiceServer save_server_;
  std::unique_ptr<ros_interface::TopicWatch> watch_;
  std::unique_ptr<ros_interface::Worker<Job>> worker_;
  std::unique_ptr<dynamic_reconfigure::Server<Tunables>> tunables_;
  ros::Subscriber primitives_subscriber_;
  ros::Subscriber places_subscriber_;
};

SceneGraphNodelet::~SceneGraphNodelet() {
  stopServices();
  if (worker_ == nullptr) return;
  primitives_subscriber_.shutdown();
  places_subscriber_.shutdown();
  worker_->waitIdle(std::chrono::steady_clock::now() + std::chrono::seconds(10));
  worker_->stop();
  if (config_.output.empty() || graph_ == nullptr || graph_->stamp == Stamp{}) return;
  try {
    writeFiles();
  } catch (const std::exception& e) {
    NODELET_ERROR_STREAM("map not saved: " << e.what());
  }
}

void SceneGraphNodelet::start() {
  config_ = loadConfig<SceneGraphNodeletConfig>();
  if (config_.object_tasks.empty()) {
    throw std::runtime_error("parameter '" + getPrivateNodeHandle().resolveName("object_tasks") +
                             "' is not set: it names the YAML file of the tasks (launch argument "
                             "object_tasks:=...)");
  }
  const auto object_tasks = ros_interface::loadTaskList(config_.object_tasks, config_.models);
  adoptAlphaOfModels();
  builder_ = std::make_unique<scene_graph::SceneGraphBuilder>(config_.scene_graph);
  builder_->setObjectTasks(object_tasks);
  builder_->setPlaceTasks(config_.place_tasks.empty()
                              ? object_tasks
                              : ros_interface::loadTaskList(config_.place_tasks, config_.models));
  markers_ =
      std::make_unique<ros_interface::SceneGraphMarkers>(config_.markers, config_.world_frame);
  worker_ =
      std::make_unique<ros_interface::Worker<Job>>(10000, [this](const Job& job) { process(job); });
  startTopics();
}

void SceneGraphNodelet::adoptAlphaOfModels() {
  if (config_.models.empty() || getPrivateNodeHandle().hasParam("object_alpha")) return;
  config_.scene_graph.object_alpha = segmentation::loadModelSet(config_.models).alpha;
  // dynamic_reconfigure starts from the parameter server.
  getPrivateNodeHandle().setParam("object_alpha", config_.scene_graph.object_alpha);
}

void SceneGraphNodelet::startTopics() {
  ros::NodeHandle& handle = getNodeHandle();
  graph_publisher_ = handle.advertise<msg::SceneGraph>("scene_graph", 10, true);
  marker_publisher_ =
      handle.advertise<visualization_msgs::MarkerArray>("scene_graph_markers", 10, true);
  tunables_ = std::make_unique<dynamic_reconfigure::Server<Tunables>>(getPrivateNodeHandle());
  tunables_->setCallback([this](Tunables& tunables, std::uint32_t) { onTunables(tunables); });
  primitives_subscriber_ =
      handle.subscribe("object_primitives", 1000, &SceneGraphNodelet::onPrimitives, this);
  places_subscriber_ = handle.subscribe("place_graph", 100, &SceneGraphNodelet::onPlaces, this);
  watch_ = std::make_unique<ros_interface::TopicWatch>(report(), config_.patience_s);
  watch_->add(places_subscriber_, "place_graph");
  save_server_ = serviceHandle().advertiseService("save_map", &SceneGraphNodelet::saveMap, this);
}

void SceneGraphNodelet::onPrimitives(const msg::ObjectPrimitivesConstPtr& message) {
  report().countInput();
  worker_->push([this, message](scene_graph::SceneGraphBuilder& builder) {
    std::vector<ObjectPrimitivePtr> primitives;
    for (const auto& primitive : message->primitives) {
      primitives.push_back(ros_interface::fromMessage(primitive));
    }
    const auto update = builder.addPrimitives(primitives);
    if (!update.error.empty()) report().countDropped("unusable primitive", update.error);
  });
  for (const auto& primitive : message->primitives) primitives_.noteId(primitive.id);
}

void SceneGraphNodelet::onPlaces(const msg::PlaceGraphConstPtr& message) {
  watch_->noteMessage(0);
  report().countInput();
  worker_->push([message](scene_graph::SceneGraphBuilder& builder) {
    builder.setPlaces(ros_interface::fromMessage(*message));
  });
  places_.noteStamp(ros_interface::toStamp(message->header.stamp));
}

void SceneGraphNodelet::onTunables(const Tunables& tunables) {
  worker_->push([this, tunables](scene_graph::SceneGraphBuilder& builder) {
    scene_graph::SceneGraphConfig config = config_.scene_graph;
    config.object_alpha = tunables.object_alpha;
    config.object_delta = tunables.object_delta;
    config.object_top_k = tunables.object_top_k;
    config.object_delta_bits = tunables.object_delta_bits;
    config.place_alpha = tunables.place_alpha;
    config.place_delta = tunables.place_delta;
    config.place_top_k = tunables.place_top_k;
    config.prune_null = tunables.prune_null;
    config.min_object_score = tunables.min_object_score;
    builder.setConfig(config);
  });
}

void SceneGraphNodelet::process(const Job& job) {
  try {
    job(*builder_);
  } catch (const std::exception& e) {
    report().countDropped("unusable input", e.what());
  }
  if (worker_->size() > 1) return;  // more is waiting: one clustering for all of it
  try {
    const ros_interface::StageTimer timer;
    publish(builder_->snapshot());
    report().countProcessed(timer.elapsedMs());
  } catch (const std::exception& e) {
    report().countDropped("error", e.what());
  }
}

void SceneGraphNodelet::publish(const scene_graph::SceneGraphPtr& graph) {
  {
    const std::lock_guard<std::mutex> lock(graph_mutex_);
    if (graph == graph_) return;
    graph_ = graph;
  }
  graph_publisher_.publish(
      ros_interface::toMessage(*graph, config_.world_frame, config_.with_embeddings));
  marker_publisher_.publish(markers_->update(*graph));
  report().set("primitives", std::to_string(graph->primitives.size()));
  report().set("objects", std::to_string(graph->objects.size()));
  report().set("places", std::to_string(graph->places->places.size()));
  report().set("regions", std::to_string(graph->regions.size()));
}

msg::FinishResponse SceneGraphNodelet::finish(const msg::FinishRequest& request,
                                              Deadline deadline) {
  const bool has_all = primitives_.wait(request.last_id, {}, deadline) &&
                       places_.wait(0, ros_interface::toStamp(request.stamp), deadline);
  msg::FinishResponse response;
  response.success = worker_->waitIdle(deadline) && has_all;
  response.message = response.success ? "all is in the graph" : "primitives or places are missing";
  const std::lock_guard<std::mutex> lock(graph_mutex_);
  if (graph_ != nullptr) response.stamp = ros_interface::toRosTime(graph_->stamp);
  return response;
}

bool SceneGraphNodelet::saveMap(std_srvs::Trigger::Request&,
                                std_srvs::Trigger::Response& response) {
  try {
    if (config_.output.empty()) throw std::runtime_error("parameter 'output' is not set");
    std::vector<std::string> problems = finishChain();
    writeFiles();
    saveUpstreamMesh(problems);
    for (const auto& problem : problems) report().warn("save_map", problem);
    response.message = std::filesystem::absolute(config_.output).string();
    response.success = 1;
  } catch (const std::exception& e) {
    response.message = std::string("map not saved: ") + e.what();
    response.success = 0;
  }
  return true;
}

std::vector<std::string> SceneGraphNodelet::finishChain() {
  std::vector<std::string> stages;
  for (const auto& stage : config_.upstream) stages.push_back(getNodeHandle().resolveName(stage));
  auto upstream = ros_interface::finishStages(stages);
  msg::FinishRequest request;
  request.last_id = upstream.last_id;
  request.stamp = ros_interface::toRosTime(upstream.stamp);
  const auto own = finish(request, std::chrono::steady_clock::now() + std::chrono::seconds(30));
  if (!own.success) upstream.problems.push_back(getName() + ": " + own.message);
  return upstream.problems;
}

void SceneGraphNodelet::saveUpstreamMesh(std::vector<std::string>& problems) {
  if (config_.upstream.empty()) return;
  const std::string service =
      getNodeHandle().resolveName(ros::names::append(config_.upstream.back(), "save_mesh"));
  std_srvs::Trigger call;
  if (!ros::service::exists(service, false)) return;
  if (!ros::service::call(service, call) || call.response.success == 0) {
    problems.push_back(service + ": " + call.response.message);
  }
}

void SceneGraphNodelet::writeFiles() {
  scene_graph::SceneGraphPtr graph;
  {
    const std::lock_guard<std::mutex> lock(graph_mutex_);
    graph = graph_;
  }
  if (graph == nullptr) throw std::runtime_error("there is no graph yet");
  const std::filesystem::path folder(config_.output);
  std::filesystem::create_directories(folder);
  scene_graph::writeSparkDsg((folder / "scene_graph.json").string(), *graph);
  scene_graph::writeSummary((folder / "summary.json").string(), *graph);
}

}  // namespace tsg::nodelets

PLUGINLIB_EXPORT_CLASS(tsg::nodelets::SceneGraphNodelet, nodelet::Nodelet)
