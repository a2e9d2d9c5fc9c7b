// SPDX-License-Identifier: BSD-3-Clause
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>
#include <sstream>
#include <utility>

#include "awaited_job.h"
#include "chain_config.h"
#include "graph_tunables.h"
#include "question_services.h"
#include "stage_nodelet.h"
#include "task_scene_graph/language/word_encoder.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/plausibility/embedding_checks.h"
#include "task_scene_graph/ros/arrivals.h"
#include "task_scene_graph/ros/flush.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/object_conversions.h"
#include "task_scene_graph/ros/reconfigure_server.h"
#include "task_scene_graph/ros/scene_graph_publisher.h"
#include "task_scene_graph/ros/settings_follower.h"
#include "task_scene_graph/ros/task_loader.h"
#include "task_scene_graph/ros/topic_watch.h"
#include "task_scene_graph/ros/worker.h"
#include "task_scene_graph/scene_graph/builder.h"
#include "task_services.h"

namespace tsg::nodelets {

// Of save_map.
constexpr double kSaveTimeout_s = 60.0;
constexpr double kSaveQuiet_s = 15.0;

// Of a job that a service has to wait for.
constexpr auto kJobTimeout = std::chrono::seconds(60);

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
  void startInterface();
  /// See GraphAccess.
  void runJob(const Job& job);
  void startTopics();
  void startTunables();
  void check() override;
  /// Sends the frames of objects; tf forgets what is not repeated.
  void sendObjectFrames();
  /// END flushes the whole chain and writes the map.
  msg::FlushResponse flush(const msg::FlushRequest& request,
                           const ros_interface::Patience& patience) override;
  std::string reset() override;
  std::string setPaused(bool is_paused) override;

  void onPrimitives(const msg::ObjectPrimitivesConstPtr& message);
  void onPlaces(const msg::PlaceGraphConstPtr& message);
  /// @throws config::ConfigError for values out of range.
  void onTunables(const Tunables& tunables);
  void noteTuned(const TunedConfig& config);
  void process(const Job& job);
  void publish(const scene_graph::SceneGraphPtr& graph);
  /// Says how many clusters the score keeps from the graph: merging must hide nothing without a
  /// word.
  void reportHidden(const scene_graph::SceneGraph& graph, bool is_logged);
  bool saveMap(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  /// What the map of now holds, stage by stage, and what it lacks.
  ros_interface::FlushedStages flushChain(std::uint8_t mode,
                                          const ros_interface::Patience& patience);
  void flushOwn(const ros_interface::Patience& patience, ros_interface::FlushedStages& flushed);
  /// Writes all files, the graph's last. Problems with the mesh are added to `flushed`.
  /// @throws std::runtime_error if there is no graph, or it cannot be written
  std::vector<WrittenFile> writeMap(const scene_graph::SceneGraphPtr& graph, bool is_end,
                                    ros_interface::FlushedStages& flushed);
  /// Nothing if there is no such stage, or if it could not be saved.
  std::vector<WrittenFile> saveUpstreamMesh(const scene_graph::SceneGraph& graph, bool is_end,
                                            ros_interface::FlushedStages& flushed);
  std::vector<WrittenFile> writeGraph(const scene_graph::SceneGraph& graph);
  scene_graph::SceneGraphPtr graph();
  std::vector<std::string> upstreamServices(const std::string& name);
  /// Nothing has arrived yet.
  static bool isEmpty(const scene_graph::SceneGraphPtr& graph) {
    return graph == nullptr || graph->stamp == Stamp{};
  }
  std::string explainEmpty() {
    return "neither primitives nor places: " + report().describeInput("message");
  }
  std::vector<config::YamlLine> describeRun() const;

  SceneGraphNodeletConfig config_;
  std::shared_ptr<language::WordEncoder> encoder_;
  std::unique_ptr<scene_graph::SceneGraphBuilder> builder_;  ///< the worker's own
  std::chrono::steady_clock::time_point newest_findings_;    ///< the worker's own
  bool is_tuned_ = false;                                    ///< the worker's own
  std::mutex graph_mutex_;
  scene_graph::SceneGraphPtr graph_;
  std::atomic<std::uint64_t> num_resets_{0};  ///< of the builder
  std::vector<WrittenFile> files_at_end_;     ///< written by flush; of the services' thread
  scene_graph::SceneGraphPtr graph_at_end_;   ///< ... and what they hold
  ros_interface::Arrivals primitives_;
  ros_interface::Arrivals places_;
  std::unique_ptr<ros_interface::SceneGraphPublisher> publisher_;
  ros::Publisher tf_publisher_;  ///< with object_frames only
  ros::ServiceServer save_server_;
  std::unique_ptr<ros_interface::TopicWatch> watch_;
  std::unique_ptr<ros_interface::Worker<Job>> worker_;
  std::unique_ptr<ros_interface::ReconfigureServer<Tunables>> tunables_;
  std::unique_ptr<ros_interface::SettingsFollower> upstream_settings_;
  ros::Subscriber primitives_subscriber_;
  ros::Subscriber places_subscriber_;
  ros::CallbackQueue interface_queue_;  ///< of tasks and questions: a save holds none of them up
  ros::NodeHandle interface_handle_;
  std::unique_ptr<TaskServices> tasks_;
  std::unique_ptr<QuestionServices> questions_;
  std::unique_ptr<ros::AsyncSpinner> interface_spinner_;
};

SceneGraphNodelet::~SceneGraphNodelet() {
  stopServices();
  if (worker_ == nullptr) return;
  if (interface_spinner_ != nullptr) interface_spinner_->stop();
  primitives_subscriber_.shutdown();
  places_subscriber_.shutdown();
  worker_->waitIdle(std::chrono::steady_clock::now() + std::chrono::seconds(10));
  worker_->stop();
  ros_interface::EndReport end{getName(), config_.output, files_at_end_, "", ""};
  if (isEmpty(graph_)) end.reason = explainEmpty();
  const bool is_written = graph_at_end_ == graph_;
  try {
    if (!is_written && end.reason.empty() && !end.folder.empty()) end.files = writeGraph(*graph_);
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
  encoder_ = std::make_shared<language::WordEncoder>(config_.models.string());
  setTasks();
  worker_ =
      std::make_unique<ros_interface::Worker<Job>>(10000, [this](const Job& job) { process(job); });
  startTopics();
}

void SceneGraphNodelet::setTasks() {
  const auto tasks = ros_interface::loadChainTasks(config_.object_tasks.string(),
                                                   config_.place_tasks.string(), *encoder_);
  builder_->setObjectTasks(tasks.objects);
  builder_->setPlaceTasks(tasks.places);
  for (const auto& warning : tasks.warnings) report().warn(warning, warning);
}

void SceneGraphNodelet::startInterface() {
  interface_handle_ = ros::NodeHandle(getPrivateNodeHandle());
  interface_handle_.setCallbackQueue(&interface_queue_);
  const GraphAccess access{[this] { return graph(); }, [this](const Job& job) { runJob(job); },
                           [this](const std::string& name) { return upstreamServices(name); }};
  tasks_ = std::make_unique<TaskServices>(
      getPrivateNodeHandle(), interface_handle_, access, encoder_,
      TaskServices::Files{config_.object_tasks, config_.place_tasks});
  questions_ = std::make_unique<QuestionServices>(interface_handle_, access, encoder_);
  interface_spinner_ = std::make_unique<ros::AsyncSpinner>(1, &interface_queue_);
  interface_spinner_->start();
}

void SceneGraphNodelet::runJob(const Job& job) {
  const auto awaited = std::make_shared<AwaitedJob>();
  const bool is_queued = worker_->pushOrder([this, &job, awaited](auto& builder) {
    awaited->run([&] {
      job(builder);
      publish(builder.snapshot());
    });
  });
  if (!is_queued) throw std::runtime_error("the stage ends");
  awaited->wait(kJobTimeout);
}

void SceneGraphNodelet::startTopics() {
  ros::NodeHandle& handle = getNodeHandle();
  publisher_ = std::make_unique<ros_interface::SceneGraphPublisher>(
      handle, report(),
      ros_interface::SceneGraphPublisher::Options{config_.world_frame, config_.with_embeddings,
                                                  config_.markers});
  if (!config_.object_frames.empty()) {
    tf_publisher_ = handle.advertise<tf2_msgs::TFMessage>("/tf", 100);
  }
  startTunables();
  // Debian 11's nodelet queue takes nothing before the nodelet has started: latched messages are
  // lost.
  ros::NodeHandle settings_handle(handle);
  settings_handle.setCallbackQueue(serviceHandle().getCallbackQueue());
  upstream_settings_ =
      std::make_unique<ros_interface::SettingsFollower>(settings_handle, config_.upstream);
  primitives_subscriber_ =
      handle.subscribe("object_primitives", 0, &SceneGraphNodelet::onPrimitives, this);
  places_subscriber_ = handle.subscribe("place_graph", 100, &SceneGraphNodelet::onPlaces, this);
  watch_ = std::make_unique<ros_interface::TopicWatch>(report(), config_.patience_s);
  watch_->add(places_subscriber_, "place_graph");
  startInterface();
  worker_->pushOrder([](scene_graph::SceneGraphBuilder&) {});  // publishes the empty graph
  save_server_ = serviceHandle().advertiseService("save_map", &SceneGraphNodelet::saveMap, this);
}

void SceneGraphNodelet::startTunables() {
  tunables_ = std::make_unique<ros_interface::ReconfigureServer<Tunables>>(
      getPrivateNodeHandle(), toTunables({config_.scene_graph, config_.markers}),
      ros_interface::ReconfigureServer<Tunables>::Callbacks{
          [this](const Tunables& tunables) { onTunables(tunables); },
          [this](const std::string& problem) { report().warn(problem, problem); }});
}

void SceneGraphNodelet::check() {
  watch_->check();
  sendObjectFrames();
}

void SceneGraphNodelet::sendObjectFrames() {
  const scene_graph::SceneGraphPtr newest = graph();
  if (config_.object_frames.empty() || newest == nullptr) return;
  const auto frames =
      ros_interface::toObjectFrames(*newest, config_.object_frames, ros::Time::now());
  if (!frames.transforms.empty()) tf_publisher_.publish(frames);
}

void SceneGraphNodelet::onPrimitives(const msg::ObjectPrimitivesConstPtr& message) {
  report().countInput();
  worker_->pushOrder([this, message](scene_graph::SceneGraphBuilder& builder) {
    if (message->is_reset != 0) {
      builder.reset();
      ++num_resets_;
    }
    std::vector<PrimitiveId> withdrawn;
    for (const std::uint64_t id : message->withdrawn) withdrawn.push_back({id});
    builder.erasePrimitives(withdrawn);
    const auto update = builder.addPrimitives(
        ros_interface::fromMessage(*message, primitives_subscriber_.getTopic()));
    if (!update.error.empty()) report().countDropped("unusable primitive", update.error);
  });
  if (message->sequence > 0) primitives_.note(message->sequence);
}

void SceneGraphNodelet::onPlaces(const msg::PlaceGraphConstPtr& message) {
  watch_->noteMessage(0);
  report().countInput();
  worker_->pushOrder([this, message](scene_graph::SceneGraphBuilder& builder) {
    builder.setPlaces(ros_interface::fromMessage(*message, places_subscriber_.getTopic()));
  });
  places_.note(message->sequence);
}

void SceneGraphNodelet::onTunables(const Tunables& tunables) {
  const TunedConfig config =
      fromTunables(tunables, {config_.scene_graph, config_.markers}, getName());
  noteTuned(config);
  worker_->pushOrder([this, config](scene_graph::SceneGraphBuilder& builder) {
    builder.setConfig(config.graph);
    is_tuned_ = true;
    publisher_->setMarkerConfig(config.markers, tasks_->numbers());
  });
}

void SceneGraphNodelet::noteTuned(const TunedConfig& config) {
  std::map<std::string, std::string> values;
  for (const auto& setting : config::listSettings(config.graph, {})) {
    values[setting.name] = setting.value;
  }
  for (const auto& setting : config::listSettings(config.markers, {})) {
    values["markers/" + setting.name] = setting.value;
  }
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
  publisher_->publish(graph, tasks_->numbers());
  tasks_->publish(*graph);
  sendObjectFrames();
  report().set("primitives", std::to_string(graph->primitives.size()));
  report().set("objects", std::to_string(graph->objects.size()));
  report().set("places", std::to_string(graph->places->places.size()));
  report().set("regions", std::to_string(graph->regions.size()));
  const auto now = std::chrono::steady_clock::now();
  if (std::exchange(is_tuned_, false)) reportHidden(*graph, true);
  if (now - newest_findings_ < kFindingsPeriod) return;
  reportHidden(*graph, false);
  newest_findings_ = now;
  std::map<std::string, std::string> findings;
  for (const auto& finding : plausibility::checkGraph(*builder_, *graph)) {
    findings.emplace(finding.check, plausibility::toText(finding));
  }
  report().setFindings(std::move(findings));
}

void SceneGraphNodelet::reportHidden(const scene_graph::SceneGraph& graph, bool is_logged) {
  const auto clusters = builder_->computeObjectClusters();
  const auto serving = std::count_if(clusters.begin(), clusters.end(),
                                     [](const auto& cluster) { return cluster.task > 0; });
  const auto hidden = static_cast<std::size_t>(serving) - graph.objects.size();
  std::ostringstream text;
  text << hidden << " of " << serving << " clusters that serve a task: the cosine of their mean is "
       << "below " << graph.config.publishedFrom() << " (min_object_score)";
  report().set("objects hidden", hidden == 0 ? "0" : text.str());
  if (is_logged) {
    NODELET_INFO_STREAM("[" << getName()
                            << "] tuned: " << formatCount(graph.objects.size(), "object")
                            << "; hidden: " << text.str());
  }
}

msg::FlushResponse SceneGraphNodelet::flush(const msg::FlushRequest& request,
                                            const ros_interface::Patience& patience) {
  ros_interface::FlushedStages flushed;
  msg::FlushResponse response;
  if (request.mode == msg::FlushRequest::END) {
    flushed = flushChain(request.mode, patience);
    try {
      const scene_graph::SceneGraphPtr newest = graph();
      if (!config_.output.empty()) files_at_end_ = writeMap(newest, true, flushed);
      graph_at_end_ = newest;
    } catch (const std::exception& e) {
      flushed.missing.push_back(getName() + ": " + e.what());
    }
  } else {
    flushed.sequence = request.sequence;
    flushed.place_sequence = request.place_sequence;
    flushOwn(patience, flushed);
  }
  response.missing = flushed.missing;
  response.content = flushed.contents.back();
  return response;
}

bool SceneGraphNodelet::saveMap(std_srvs::Trigger::Request&,
                                std_srvs::Trigger::Response& response) {
  try {
    if (config_.output.empty()) throw std::runtime_error("parameter 'output' is not set");
    auto flushed = flushChain(msg::FlushRequest::SNAPSHOT,
                              ros_interface::Patience::from(kSaveTimeout_s, kSaveQuiet_s));
    const std::vector<WrittenFile> files = writeMap(graph(), false, flushed);
    NODELET_INFO_STREAM("[" << getName() << "] " << describeWritten(config_.output, files));
    response.message = config_.output.string();
    for (const auto& line : flushed.contents) response.message += "\n" + line;
    for (const auto& line : flushed.missing) {
      response.message += "\nmissing: " + line;
      report().warn("save_map", "save_map: missing: " + line);
    }
    response.success = flushed.missing.empty() ? 1 : 0;
  } catch (const std::exception& e) {
    response.message = std::string("no map was written: ") + e.what();
    response.success = 0;
    NODELET_ERROR_STREAM("[" << getName() << "] " << response.message);
  }
  return true;
}

ros_interface::FlushedStages SceneGraphNodelet::flushChain(
    std::uint8_t mode, const ros_interface::Patience& patience) {
  std::vector<std::string> stages;
  for (const auto& stage : config_.upstream) stages.push_back(getNodeHandle().resolveName(stage));
  ros_interface::FlushedStages flushed = ros_interface::flushStages(stages, mode, patience);
  flushOwn(patience, flushed);
  return flushed;
}

void SceneGraphNodelet::flushOwn(const ros_interface::Patience& patience,
                                 ros_interface::FlushedStages& flushed) {
  const auto miss = [&](const std::string& line) {
    flushed.missing.push_back(getName() + ": " + line);
  };
  if (!primitives_.wait(flushed.sequence, patience)) miss("object primitives have not arrived");
  if (!places_.wait(flushed.place_sequence, patience)) miss("the newest places have not arrived");
  if (!worker_->waitHandled(patience)) miss("the clustering is still at work");
  const scene_graph::SceneGraphPtr newest = graph();
  const std::size_t num_objects = newest == nullptr ? 0 : newest->objects.size();
  const std::size_t num_regions = newest == nullptr ? 0 : newest->regions.size();
  flushed.contents.push_back(getName() + ": " + formatCount(num_objects, "object") + ", " +
                             formatCount(num_regions, "region"));
}

scene_graph::SceneGraphPtr SceneGraphNodelet::graph() {
  const std::lock_guard<std::mutex> lock(graph_mutex_);
  return graph_;
}

std::vector<WrittenFile> SceneGraphNodelet::writeMap(const scene_graph::SceneGraphPtr& graph,
                                                     bool is_end,
                                                     ros_interface::FlushedStages& flushed) {
  if (isEmpty(graph)) throw std::runtime_error(explainEmpty());
  const std::vector<WrittenFile> mesh = saveUpstreamMesh(*graph, is_end, flushed);
  std::vector<WrittenFile> files = writeGraph(*graph);
  files.insert(files.end(), mesh.begin(), mesh.end());
  return files;
}

std::vector<WrittenFile> SceneGraphNodelet::saveUpstreamMesh(
    const scene_graph::SceneGraph& graph, bool is_end, ros_interface::FlushedStages& flushed) {
  if (config_.upstream.empty()) return {};
  const std::string service =
      getNodeHandle().resolveName(ros::names::append(config_.upstream.back(), "save_mesh"));
  if (!ros::service::exists(service, false)) return {};
  msg::SaveMesh call;
  call.request.folder = config_.output.string();
  call.request.has_objects = 1;
  call.request.is_end = is_end ? 1 : 0;
  for (const auto& [primitive, object] : scene_graph::computeObjectOfPrimitives(graph)) {
    call.request.primitives.push_back(primitive.value);
    call.request.objects.push_back(object);
  }
  if (!ros::service::call(service, call) || call.response.success == 0) {
    flushed.missing.push_back(service + ": " + call.response.message);
    return {};
  }
  std::vector<WrittenFile> files;
  for (std::size_t i = 0; i < call.response.files.size(); ++i) {
    files.push_back({call.response.files[i], call.response.contents[i]});
  }
  return files;
}

std::vector<WrittenFile> SceneGraphNodelet::writeGraph(const scene_graph::SceneGraph& graph) {
  std::filesystem::create_directories(config_.output);
  std::vector<WrittenFile> files = map::writeGraphFiles(config_.output, graph);
  std::vector<config::StageSettings> stages = upstream_settings_->settings();
  stages.push_back(settings());
  files.push_back(map::writeSettingsFile(config_.output, describeRun(), stages));
  return files;
}

std::vector<std::string> SceneGraphNodelet::upstreamServices(const std::string& name) {
  std::vector<std::string> services;
  for (const auto& stage : config_.upstream) {
    const std::string service = getNodeHandle().resolveName(ros::names::append(stage, name));
    if (ros::service::exists(service, false)) services.push_back(service);
  }
  return services;
}

std::string SceneGraphNodelet::setPaused(bool is_paused) {
  std::string problems = StageNodelet::setPaused(is_paused);
  for (const auto& service : upstreamServices(is_paused ? "pause" : "resume")) {
    std_srvs::Trigger call;
    if (ros::service::call(service, call) && call.response.success != 0) continue;
    problems += (problems.empty() ? "" : "; ") + service + " failed: " + call.response.message;
  }
  return problems;
}

std::string SceneGraphNodelet::reset() {
  const std::uint64_t before = num_resets_;
  const auto services = upstreamServices("reset");
  for (const auto& service : services) {
    std_srvs::Trigger call;
    if (ros::service::call(service, call) && call.response.success != 0) continue;
    throw std::runtime_error(service + " failed: " + call.response.message);
  }
  // mesh_fusion says it on the topic of the primitives, between what was before and what follows.
  const auto patience = ros_interface::Patience::from(5.0, 5.0);
  const bool is_told =
      !services.empty() && ros_interface::waitPatiently([&] { return num_resets_ > before; },
                                                        [] { return 0; }, patience);
  if (!is_told)
    worker_->pushOrder([](scene_graph::SceneGraphBuilder& builder) { builder.reset(); });
  worker_->waitHandled(patience);
  return "the map is forgotten; tasks and parameters stay";
}

std::vector<config::YamlLine> SceneGraphNodelet::describeRun() const {
  std::vector<config::YamlLine> lines{{"program", config::quoteYaml("live, " + getName()), ""}};
  lines.push_back({"model_set", config::quoteYaml(encoder_->modelSetName()), ""});
  return lines;
}

}  // namespace tsg::nodelets

PLUGINLIB_EXPORT_CLASS(tsg::nodelets::SceneGraphNodelet, nodelet::Nodelet)
