// SPDX-License-Identifier: BSD-3-Clause
#include <std_srvs/Trigger.h>
#include <task_scene_graph/SceneGraphTuningConfig.h>
#include <visualization_msgs/MarkerArray.h>

#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>

#include "chain_config.h"
#include "stage_nodelet.h"
#include "task_scene_graph/mapping/ply.h"
#include "task_scene_graph/pipeline/map_files.h"
#include "task_scene_graph/plausibility/embedding_checks.h"
#include "task_scene_graph/ros/arrivals.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/reconfigure_server.h"
#include "task_scene_graph/ros/run_nodelets.h"
#include "task_scene_graph/ros/scene_graph_conversions.h"
#include "task_scene_graph/ros/scene_graph_markers.h"
#include "task_scene_graph/ros/settings_follower.h"
#include "task_scene_graph/ros/task_loader.h"
#include "task_scene_graph/ros/topic_watch.h"
#include "task_scene_graph/ros/worker.h"
#include "task_scene_graph/scene_graph/builder.h"

namespace tsg::nodelets {

using Tunables = ::task_scene_graph::SceneGraphTuningConfig;  // from cfg/SceneGraphTuning.cfg

/// Copies the parameters that may be changed while running.
template <typename From, typename To>
void copyTunables(const From& from, To& to) {
  to.object_alpha = from.object_alpha;
  to.object_delta = from.object_delta;
  to.object_top_k = from.object_top_k;
  to.object_delta_bits = from.object_delta_bits;
  to.place_alpha = from.place_alpha;
  to.place_delta = from.place_delta;
  to.place_top_k = from.place_top_k;
  to.prune_null = from.prune_null;
  to.min_object_score = from.min_object_score;
}

// What looks wrong with the embeddings is looked at so often: it costs tens of milliseconds.
constexpr auto kFindingsPeriod = std::chrono::seconds(5);

/// Primitives, places and tasks -> the scene graph, its markers and its files.
class SceneGraphNodelet : public StageNodelet {
 public:
  ~SceneGraphNodelet() override;

 private:
  using Job = std::function<void(scene_graph::SceneGraphBuilder&)>;

  void start() override;
  void setTasks();
  void startTopics();
  void startTunables();
  void check() override { watch_->check(); }
  msg::FinishResponse finish(const msg::FinishRequest& request, Deadline deadline) override;

  void onPrimitives(const msg::ObjectPrimitivesConstPtr& message);
  void onPlaces(const msg::PlaceGraphConstPtr& message);
  /// @throws config::ConfigError for values out of range.
  void onTunables(const Tunables& tunables);
  void noteTuned(const scene_graph::SceneGraphConfig& config);
  void process(const Job& job);
  void publish(const scene_graph::SceneGraphPtr& graph);
  bool saveMap(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  std::vector<std::string> finishChain();
  /// Nothing if there is none, or if it could not be saved.
  std::vector<WrittenFile> saveUpstreamMesh(std::vector<std::string>& problems);
  std::vector<WrittenFile> writeFiles();
  /// Nothing has arrived yet.
  static bool isEmpty(const scene_graph::SceneGraphPtr& graph) {
    return graph == nullptr || graph->stamp == Stamp{};
  }
  std::string explainEmpty() {
    return "neither primitives nor places: " + report().describeInput("message");
  }
  std::vector<config::YamlLine> describeRun() const;

  SceneGraphNodeletConfig config_;
  std::string model_set_name_;                               ///< "" without one
  std::unique_ptr<scene_graph::SceneGraphBuilder> builder_;  ///< the worker's own
  std::unique_ptr<ros_interface::SceneGraphMarkers> markers_;
  std::chrono::steady_clock::time_point newest_findings_;  ///< the worker's own
  std::mutex graph_mutex_;
  scene_graph::SceneGraphPtr graph_;
  ros_interface::Arrivals primitives_;
  ros_interface::Arrivals places_;
  ros::Publisher graph_publisher_;
  ros::Publisher marker_publisher_;
  ros::ServiceServer save_server_;
  std::unique_ptr<ros_interface::TopicWatch> watch_;
  std::unique_ptr<ros_interface::Worker<Job>> worker_;
  std::unique_ptr<ros_interface::ReconfigureServer<Tunables>> tunables_;
  std::unique_ptr<ros_interface::SettingsFollower> upstream_settings_;
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
  ros_interface::EndReport end{getName(), config_.output, {}, "", ""};
  if (isEmpty(graph_)) end.reason = explainEmpty();
  try {
    if (end.reason.empty() && !end.folder.empty()) end.files = writeFiles();
  } catch (const std::exception& e) {
    end.problem = std::string("map not saved: ") + e.what();
  }
  ros_interface::reportEnd(end);
}

void SceneGraphNodelet::start() {
  config_ = loadConfig<SceneGraphNodeletConfig>(suggestFromModels);
  if (config_.object_tasks.empty()) {
    throw std::runtime_error("parameter '" + getPrivateNodeHandle().resolveName("object_tasks") +
                             "' is not set: it names the YAML file of the tasks (launch argument "
                             "object_tasks:=...)");
  }
  builder_ =
      std::make_unique<scene_graph::SceneGraphBuilder>(config_.scene_graph, config_.world_frame);
  setTasks();
  markers_ =
      std::make_unique<ros_interface::SceneGraphMarkers>(config_.markers, config_.world_frame);
  worker_ =
      std::make_unique<ros_interface::Worker<Job>>(10000, [this](const Job& job) { process(job); });
  startTopics();
}

void SceneGraphNodelet::setTasks() {
  const auto tasks = ros_interface::loadChainTasks(
      config_.object_tasks.string(), config_.place_tasks.string(), config_.models.string());
  builder_->setObjectTasks(tasks.objects);
  builder_->setPlaceTasks(tasks.places);
  for (const auto& warning : tasks.warnings) report().warn(warning, warning);
  if (!config_.models.empty()) {
    model_set_name_ = segmentation::loadModelSet(config_.models.string()).name;
  }
}

void SceneGraphNodelet::startTopics() {
  ros::NodeHandle& handle = getNodeHandle();
  graph_publisher_ = handle.advertise<msg::SceneGraph>("scene_graph", 10, true);
  marker_publisher_ =
      handle.advertise<visualization_msgs::MarkerArray>("scene_graph_markers", 10, true);
  startTunables();
  upstream_settings_ = std::make_unique<ros_interface::SettingsFollower>(handle, config_.upstream);
  primitives_subscriber_ =
      handle.subscribe("object_primitives", 1000, &SceneGraphNodelet::onPrimitives, this);
  places_subscriber_ = handle.subscribe("place_graph", 100, &SceneGraphNodelet::onPlaces, this);
  watch_ = std::make_unique<ros_interface::TopicWatch>(report(), config_.patience_s);
  watch_->add(places_subscriber_, "place_graph");
  worker_->push([](scene_graph::SceneGraphBuilder&) {});  // publishes the empty graph
  save_server_ = serviceHandle().advertiseService("save_map", &SceneGraphNodelet::saveMap, this);
}

void SceneGraphNodelet::startTunables() {
  Tunables initial = Tunables::__getDefault__();
  copyTunables(config_.scene_graph, initial);
  tunables_ = std::make_unique<ros_interface::ReconfigureServer<Tunables>>(
      getPrivateNodeHandle(), initial,
      ros_interface::ReconfigureServer<Tunables>::Callbacks{
          [this](const Tunables& tunables) { onTunables(tunables); },
          [this](const std::string& problem) { report().warn(problem, problem); }});
}

void SceneGraphNodelet::onPrimitives(const msg::ObjectPrimitivesConstPtr& message) {
  report().countInput();
  worker_->push([this, message](scene_graph::SceneGraphBuilder& builder) {
    const auto update = builder.addPrimitives(
        ros_interface::fromMessage(*message, primitives_subscriber_.getTopic()));
    if (!update.error.empty()) report().countDropped("unusable primitive", update.error);
  });
  for (const auto& primitive : message->primitives) primitives_.noteId(primitive.id);
}

void SceneGraphNodelet::onPlaces(const msg::PlaceGraphConstPtr& message) {
  watch_->noteMessage(0);
  report().countInput();
  worker_->push([this, message](scene_graph::SceneGraphBuilder& builder) {
    builder.setPlaces(ros_interface::fromMessage(*message, places_subscriber_.getTopic()));
  });
  places_.noteStamp(ros_interface::toStamp(message->header.stamp));
}

void SceneGraphNodelet::onTunables(const Tunables& tunables) {
  scene_graph::SceneGraphConfig config = config_.scene_graph;
  copyTunables(tunables, config);
  config::validate(config, getName());
  noteTuned(config);
  worker_->push([config](scene_graph::SceneGraphBuilder& builder) { builder.setConfig(config); });
}

void SceneGraphNodelet::noteTuned(const scene_graph::SceneGraphConfig& config) {
  std::map<std::string, std::string> values;
  for (const auto& setting : config::listSettings(config, {})) values[setting.name] = setting.value;
  config::StageSettings all = settings();
  for (auto& setting : all.settings) {
    const auto found = values.find(setting.name);
    if (found == values.end() || found->second == setting.value) continue;
    setting.value = found->second;
    setting.origin = "dynamic_reconfigure";
  }
  setSettings(all);
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
  const auto now = std::chrono::steady_clock::now();
  if (now - newest_findings_ < kFindingsPeriod) return;
  newest_findings_ = now;
  std::map<std::string, std::string> findings;
  for (const auto& finding : plausibility::checkGraph(*builder_, *graph)) {
    findings.emplace(finding.check, plausibility::toText(finding));
  }
  report().setFindings(std::move(findings));
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
    const std::vector<WrittenFile> mesh = saveUpstreamMesh(problems);
    for (const auto& problem : problems) report().warn("save_map", problem);
    std::vector<WrittenFile> files = writeFiles();
    files.insert(files.end(), mesh.begin(), mesh.end());
    NODELET_INFO_STREAM("[" << getName() << "] " << describeWritten(config_.output, files));
    response.message = config_.output.string();
    response.success = 1;
  } catch (const std::exception& e) {
    response.message = std::string("no map was written: ") + e.what();
    response.success = 0;
    NODELET_ERROR_STREAM("[" << getName() << "] " << response.message);
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

std::vector<WrittenFile> SceneGraphNodelet::saveUpstreamMesh(std::vector<std::string>& problems) {
  if (config_.upstream.empty()) return {};
  const std::string service =
      getNodeHandle().resolveName(ros::names::append(config_.upstream.back(), "save_mesh"));
  std_srvs::Trigger call;
  if (!ros::service::exists(service, false)) return {};
  if (!ros::service::call(service, call) || call.response.success == 0) {
    problems.push_back(service + ": " + call.response.message);
    return {};
  }
  const std::filesystem::path path = call.response.message;
  const std::string name = path.parent_path() == config_.output ? "mesh.ply" : path.string();
  return {{name, std::to_string(mapping::countPlyVertices(path)) + " vertices"}};
}

std::vector<WrittenFile> SceneGraphNodelet::writeFiles() {
  scene_graph::SceneGraphPtr graph;
  {
    const std::lock_guard<std::mutex> lock(graph_mutex_);
    graph = graph_;
  }
  if (isEmpty(graph)) throw std::runtime_error(explainEmpty());
  std::filesystem::create_directories(config_.output);
  std::vector<WrittenFile> files = pipeline::writeGraphFiles(config_.output, *graph);
  std::vector<config::StageSettings> stages = upstream_settings_->settings();
  stages.push_back(settings());
  files.push_back(pipeline::writeSettingsFile(config_.output, describeRun(), stages));
  return files;
}

std::vector<config::YamlLine> SceneGraphNodelet::describeRun() const {
  std::vector<config::YamlLine> lines{{"program", config::quoteYaml("live, " + getName()), ""}};
  lines.push_back({"model_set", config::quoteYaml(model_set_name_), ""});
  return lines;
}

}  // namespace tsg::nodelets

PLUGINLIB_EXPORT_CLASS(tsg::nodelets::SceneGraphNodelet, nodelet::Nodelet)
