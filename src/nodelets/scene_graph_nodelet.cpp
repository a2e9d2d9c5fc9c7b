// SPDX-License-Identifier: BSD-3-Clause
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <set>
#include <sstream>
#include <utility>

#include "awaited_job.h"
#include "chain_config.h"
#include "graph_tunables.h"
#include "map_services.h"
#include "question_services.h"
#include "stage_nodelet.h"
#include "task_scene_graph/language/word_encoder.h"
#include "task_scene_graph/plausibility/embedding_checks.h"
#include "task_scene_graph/ros/arrivals.h"
#include "task_scene_graph/ros/flush.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/object_conversions.h"
#include "task_scene_graph/ros/scene_graph_publisher.h"
#include "task_scene_graph/ros/settings_follower.h"
#include "task_scene_graph/ros/task_loader.h"
#include "task_scene_graph/ros/topic_watch.h"
#include "task_scene_graph/ros/worker.h"
#include "task_scene_graph/scene_graph/builder.h"
#include "task_services.h"

namespace tsg::nodelets {

// Of a job that a service has to wait for.
constexpr auto kJobTimeout = std::chrono::seconds(60);

// What looks wrong with the embeddings is looked at so often: it costs tens of milliseconds.
constexpr auto kFindingsPeriod = std::chrono::seconds(5);

/// Those that are no more. What is withdrawn and there anew has moved, and is replaced.
std::vector<PrimitiveId> listWithdrawn(const msg::ObjectPrimitives& message) {
  std::set<std::uint64_t> anew;
  for (const auto& primitive : message.primitives) anew.insert(primitive.id);
  std::vector<PrimitiveId> withdrawn;
  for (const std::uint64_t id : message.withdrawn) {
    if (anew.count(id) == 0) withdrawn.push_back({id});
  }
  return withdrawn;
}

/// Primitives, places and tasks -> the scene graph and its markers; MapServices has its files.
class SceneGraphNodelet : public StageNodelet {
 public:
  ~SceneGraphNodelet() override;

 private:
  using Job = std::function<void(scene_graph::SceneGraphBuilder&)>;

  void start() override;
  /// Where there is a map to go on from.
  std::optional<map::LoadedMap> loadMap() const;
  void setTasks(const std::optional<map::LoadedMap>& loaded);
  void startInterface();
  void startMapServices(const std::optional<map::LoadedMap>& loaded);
  /// See GraphAccess.
  void runJob(const Job& job);
  void startTopics();
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
  void tune(const TunedConfig& config);
  void noteTuned(const TunedConfig& config);
  void process(const Job& job);
  void publish(const scene_graph::SceneGraphPtr& graph);
  /// Says how many clusters the score keeps from the graph: merging must hide nothing without a
  /// word.
  void reportHidden(const scene_graph::SceneGraph& graph, bool is_logged);
  /// What the map of now holds, stage by stage, and what it lacks.
  ros_interface::FlushedStages flushChain(std::uint8_t mode,
                                          const ros_interface::Patience& patience);
  void flushOwn(const ros_interface::Patience& patience, ros_interface::FlushedStages& flushed);
  scene_graph::SceneGraphPtr graph();
  std::vector<std::string> upstreamServices(const std::string& name);
  /// Nothing has arrived yet.
  static bool isEmpty(const scene_graph::SceneGraphPtr& graph) {
    return graph == nullptr || graph->stamp == Stamp{};
  }
  std::string explainEmpty() {
    return "neither primitives nor places: " + report().describeInput("message");
  }
  std::vector<std::string> listUpstream();

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
  std::unique_ptr<ros_interface::TopicWatch> watch_;
  std::atomic<std::uint64_t> num_place_messages_{0};
  std::uint64_t num_noted_ = 0;  ///< of these, by `watch_`; of check()
  std::unique_ptr<ros_interface::Worker<Job>> worker_;
  std::unique_ptr<ros_interface::SettingsFollower> upstream_settings_;
  ros::Subscriber primitives_subscriber_;
  ros::Subscriber places_subscriber_;
  ros::CallbackQueue interface_queue_;  ///< of tasks and questions: a save holds none of them up
  ros::NodeHandle interface_handle_;
  std::unique_ptr<TunablesServer> tunables_;
  std::unique_ptr<TaskServices> tasks_;
  std::unique_ptr<QuestionServices> questions_;
  std::unique_ptr<MapServices> map_;
  std::atomic<bool> is_loading_{false};  ///< a map: what is in between is not published
  std::unique_ptr<ros::AsyncSpinner> interface_spinner_;
};

SceneGraphNodelet::~SceneGraphNodelet() {
  stopCallbacks();
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
    if (!is_written && end.reason.empty() && !end.folder.empty()) {
      end.files = map_->saveGraph(*builder_);
    }
  } catch (const std::exception& e) {
    end.problem = std::string("map not saved: ") + e.what();
  }
  ros_interface::reportEnd(end);
}

void SceneGraphNodelet::start() {
  config_ = loadConfig<SceneGraphNodeletConfig>(suggestFromModels);
  if (config_.object_tasks.empty() && config_.map.empty()) {
    throw std::runtime_error("parameter '" + getPrivateNodeHandle().resolveName("object_tasks") +
                             "' is not set: it names the YAML file of the tasks (launch argument "
                             "object_tasks:=...); a map to go on from (map:=...) has them, too");
  }
  builder_ =
      std::make_unique<scene_graph::SceneGraphBuilder>(config_.scene_graph, config_.world_frame);
  encoder_ = std::make_shared<language::WordEncoder>(config_.models.string());
  const std::optional<map::LoadedMap> loaded = loadMap();
  setTasks(loaded);
  if (loaded) map::restoreBuilder(loaded->map, *builder_);
  worker_ =
      std::make_unique<ros_interface::Worker<Job>>(10000, [this](const Job& job) { process(job); });
  startTopics();
  startMapServices(loaded);
}

std::optional<map::LoadedMap> SceneGraphNodelet::loadMap() const {
  if (config_.map.empty()) return std::nullopt;
  map::MapUse use;
  use.world_frame = config_.world_frame;
  use.model_set = encoder_->modelSetName();
  use.embedding_size = encoder_->embeddingSize();
  return map::loadMap(config_.map, use);
}

void SceneGraphNodelet::setTasks(const std::optional<map::LoadedMap>& loaded) {
  if (config_.object_tasks.empty()) {
    builder_->setObjectTasks(loaded->map.objectTasks());
    builder_->setPlaceTasks(loaded->map.placeTasks());
    return;
  }
  const auto tasks = ros_interface::loadChainTasks(config_.object_tasks.string(),
                                                   config_.place_tasks.string(), *encoder_);
  builder_->setObjectTasks(tasks.objects);
  builder_->setPlaceTasks(tasks.places);
  for (const auto& warning : tasks.warnings) report().warn(warning, warning);
  const Eigen::Index size =
      std::max(tasks.objects.embeddings.cols(), tasks.places.embeddings.cols());
  const Eigen::Index expected = loaded ? loaded->map.embeddingSize() : 0;
  if (size == 0 || expected == 0 || size == expected) return;
  throw std::runtime_error("the tasks' embeddings have " + std::to_string(size) +
                           " numbers, expected " + std::to_string(expected) + " as in map '" +
                           config_.map.string() + "'");
}

void SceneGraphNodelet::startMapServices(const std::optional<map::LoadedMap>& loaded) {
  MapServices::Callbacks callbacks;
  callbacks.flush = [this](std::uint8_t mode, const ros_interface::Patience& patience) {
    return flushChain(mode, patience);
  };
  callbacks.settings = [this] {
    std::vector<config::StageSettings> stages = upstream_settings_->settings();
    stages.push_back(settings());
    return stages;
  };
  callbacks.knows = [this](const std::string& stage) { return upstream_settings_->knows(stage); };
  callbacks.warn = [this](const std::string& line) { report().warn(line, line); };
  callbacks.explainEmpty = [this] { return explainEmpty(); };
  callbacks.waitFor = [this](std::uint64_t primitives, std::uint64_t places,
                             const ros_interface::Patience& patience) {
    return primitives_.wait(primitives, patience) && places_.wait(places, patience) &&
           worker_->waitHandled(patience);
  };
  callbacks.setLoading = [this](bool is_loading) { is_loading_ = is_loading; };
  callbacks.setPaused = [this](bool paused) { return setPaused(paused); };
  callbacks.isPaused = [this] { return isPaused(); };
  map_ = std::make_unique<MapServices>(
      serviceHandle(),
      MapServices::Options{getName(), config_.output, listUpstream(), config_.world_frame,
                           encoder_->modelSetName()},
      GraphAccess{[this] { return graph(); }, [this](const Job& job) { runJob(job); },
                  [this](const std::string& name) { return upstreamServices(name); }},
      std::move(callbacks));
  if (!loaded) return;
  map_->setSources(loaded->map.sources());
  for (const auto& note : loaded->notes)
    report().warn(note, "map '" + config_.map.string() + "': " + note);
}

void SceneGraphNodelet::startInterface() {
  interface_handle_ = ros::NodeHandle(getPrivateNodeHandle());
  interface_handle_.setCallbackQueue(&interface_queue_);
  const GraphAccess access{[this] { return graph(); }, [this](const Job& job) { runJob(job); },
                           [this](const std::string& name) { return upstreamServices(name); }};
  tasks_ = std::make_unique<TaskServices>(
      interface_handle_, access, encoder_,
      TaskServices::Files{config_.object_tasks, config_.place_tasks});
  questions_ = std::make_unique<QuestionServices>(interface_handle_, access, encoder_);
  tunables_ = serveTunables(
      interface_handle_, {config_.scene_graph, config_.markers},
      [this](const TunedConfig& config) { tune(config); }, report());
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
  ros::NodeHandle& handle = topicHandle();
  publisher_ = std::make_unique<ros_interface::SceneGraphPublisher>(
      handle, report(),
      ros_interface::SceneGraphPublisher::Options{config_.world_frame, config_.with_embeddings,
                                                  config_.markers});
  if (!config_.object_frames.empty()) {
    tf_publisher_ = handle.advertise<tf2_msgs::TFMessage>("/tf", 100);
  }
  startInterface();  // before the first graph, with which the tasks are published
  upstream_settings_ = std::make_unique<ros_interface::SettingsFollower>(handle, config_.upstream);
  primitives_subscriber_ =
      handle.subscribe("object_primitives", 0, &SceneGraphNodelet::onPrimitives, this);
  places_subscriber_ = handle.subscribe("place_graph", 100, &SceneGraphNodelet::onPlaces, this);
  watch_ = std::make_unique<ros_interface::TopicWatch>(report(), config_.patience_s);
  watch_->add(places_subscriber_, "place_graph");
  worker_->pushOrder([](scene_graph::SceneGraphBuilder&) {});  // publishes the graph of now
}

void SceneGraphNodelet::check() {
  for (; num_noted_ < num_place_messages_; ++num_noted_) watch_->noteMessage(0);
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
    const auto primitives = ros_interface::fromMessage(*message, primitives_subscriber_.getTopic());
    const auto withdrawn = listWithdrawn(*message);
    const bool are_moved = withdrawn.size() < message->withdrawn.size();
    builder.erasePrimitives(withdrawn);
    const auto update = builder.addPrimitives(
        primitives, are_moved ? scene_graph::Repeated::kReplace : scene_graph::Repeated::kDrop);
    if (!update.error.empty()) report().countDropped("unusable primitive", update.error);
  });
  if (message->sequence > 0) primitives_.note(message->sequence);
}

void SceneGraphNodelet::onPlaces(const msg::PlaceGraphConstPtr& message) {
  ++num_place_messages_;
  report().countInput();
  worker_->pushOrder([this, message](scene_graph::SceneGraphBuilder& builder) {
    builder.setPlaces(
        ros_interface::fromMessage(*message, places_subscriber_.getTopic(), *builder.places()));
  });
  places_.note(message->sequence);
}

void SceneGraphNodelet::tune(const TunedConfig& config) {
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
  if (worker_->size() > 1 || is_loading_) return;  // more is waiting: one clustering for all of it
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
      if (isEmpty(newest)) throw std::runtime_error(explainEmpty());
      if (!config_.output.empty()) files_at_end_ = map_->save(true, flushed);
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

ros_interface::FlushedStages SceneGraphNodelet::flushChain(
    std::uint8_t mode, const ros_interface::Patience& patience) {
  ros_interface::FlushedStages flushed = ros_interface::flushStages(listUpstream(), mode, patience);
  for (const auto& stage : flushed.absent) {
    if (!upstream_settings_->knows(stage)) continue;  // a chain without it
    flushed.missing.push_back(stage + ": has ended, and what it had with it");
  }
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

std::vector<std::string> SceneGraphNodelet::listUpstream() {
  std::vector<std::string> stages;
  for (const auto& stage : config_.upstream) stages.push_back(getNodeHandle().resolveName(stage));
  return stages;
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
  map_->setSources({});
  return "the map is forgotten; tasks and parameters stay";
}

}  // namespace tsg::nodelets

PLUGINLIB_EXPORT_CLASS(tsg::nodelets::SceneGraphNodelet, nodelet::Nodelet)
