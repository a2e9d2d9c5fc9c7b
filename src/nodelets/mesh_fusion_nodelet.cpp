// SPDX-License-Identifier: BSD-3-Clause
#include <std_srvs/Trigger.h>

#include <atomic>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <pluginlib/class_list_macros.hpp>

#include "background_stage.h"
#include "mesh_fusion_config.h"
#include "mesh_fusion_report.h"
#include "stage_nodelet.h"
#include "task_scene_graph/pipeline/object_fusion.h"
#include "task_scene_graph/ros/arrivals.h"
#include "task_scene_graph/ros/frame_matcher.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/object_follower.h"
#include "task_scene_graph/ros/rgbd_input.h"
#include "task_scene_graph/ros/topic_watch.h"
#include "task_scene_graph/ros/worker.h"

namespace tsg::nodelets {

/// Every frame -> the background stage; segmented frames and tracks -> object primitives. The
/// background stage has a thread, segmented frames have one, and objects are reconstructed on a
/// pool of lower priority: none waits for another.
class MeshFusionNodelet : public StageNodelet {
 public:
  ~MeshFusionNodelet() override;

 private:
  using Match = ros_interface::FrameMatcher::Match;
  /// A segmented frame, or what the tracker said of one, or neither: a look at what is done.
  struct ObjectJob {
    Match match;
    msg::TracksConstPtr tracks;
    bool waits = false;  ///< until all is reconstructed
  };
  struct HeldTracks {
    msg::TracksConstPtr message;
    std::chrono::steady_clock::time_point arrival;
  };

  void start() override;
  void startTopics();
  void check() override;
  msg::FinishResponse finish(const msg::FinishRequest& request, Deadline deadline) override;

  void onFrame(const RgbdFramePtr& frame);
  void onSegmentation(const msg::SegmentationConstPtr& message);
  void onTracks(const msg::TracksConstPtr& message);
  void onJumpBack();
  void enqueueMatch(std::optional<Match> match);
  /// Tracks go to reconstruction only after the frame that they speak of.
  void releaseTracks(bool all);

  void processObjects(const ObjectJob& job);
  void publishPrimitives(const std::vector<ObjectPrimitivePtr>& primitives, Stamp stamp);
  void greetPrimitivesSubscriber(const ros::SingleSubscriberPublisher& subscriber);
  bool saveMesh(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  /// mesh.ply and the occupancy map's files. Waits for the graph of what was published last.
  std::vector<WrittenFile> writeMesh(Deadline deadline);

  MeshFusionNodeletConfig config_;
  std::unique_ptr<BackgroundStage> background_;
  std::unique_ptr<pipeline::ObjectFusion> objects_;  ///< the object worker's own, as the next
  Stamp newest_tracks_;
  std::mutex primitives_mutex_;
  std::vector<ObjectPrimitivePtr> primitives_;
  Stamp primitives_stamp_;
  std::mutex tracks_mutex_;
  std::deque<HeldTracks> held_tracks_;
  Stamp newest_match_;
  ros_interface::Arrivals arrivals_;
  ros::Publisher primitives_publisher_;
  ros::ServiceServer save_server_;
  std::unique_ptr<ros_interface::FrameMatcher> matcher_;
  std::unique_ptr<ros_interface::ObjectFollower> object_follower_;
  std::unique_ptr<ros_interface::TopicWatch> watch_;
  std::unique_ptr<ros_interface::Worker<ObjectJob>> object_worker_;
  std::unique_ptr<ros_interface::RgbdInput> input_;
  ros::Subscriber segmentation_subscriber_;
  ros::Subscriber tracks_subscriber_;
};

MeshFusionNodelet::~MeshFusionNodelet() {
  stopServices();
  if (background_ == nullptr || object_worker_ == nullptr) return;
  tracks_subscriber_.shutdown();
  segmentation_subscriber_.shutdown();
  input_.reset();
  background_->stop();
  object_worker_->stop();
  ros_interface::EndReport end{getName(), config_.output, {}, "", ""};
  if (background_->newestFrame() == Stamp{}) end.reason = report().describeInput("colour image");
  try {
    if (end.reason.empty() && !end.folder.empty()) {
      end.files = writeMesh(std::chrono::steady_clock::now());
    }
  } catch (const std::exception& e) {
    end.problem = std::string("mesh not saved: ") + e.what();
  }
  ros_interface::reportEnd(end);
}

void MeshFusionNodelet::start() {
  config_ = loadConfig<MeshFusionNodeletConfig>();
  ros_interface::checkInputFiles(config_.input);
  objects_ = std::make_unique<pipeline::ObjectFusion>(config_.object_fusion);
  matcher_ =
      std::make_unique<ros_interface::FrameMatcher>(static_cast<std::size_t>(config_.frame_cache));
  object_worker_ = std::make_unique<ros_interface::Worker<ObjectJob>>(
      static_cast<std::size_t>(config_.object_queue_size),
      [this](const ObjectJob& job) { processObjects(job); });
  startTopics();
}

void MeshFusionNodelet::startTopics() {
  ros::NodeHandle& handle = getNodeHandle();
  background_ = std::make_unique<BackgroundStage>(
      handle,
      BackgroundStageOptions{config_.background_fusion, config_.input.world_frame,
                             config_.mesh_period_s, config_.octomap_period_s,
                             static_cast<std::size_t>(config_.queue_size),
                             1000000U * static_cast<std::size_t>(config_.queue_megabytes)},
      report());
  primitives_publisher_ = handle.advertise<msg::ObjectPrimitives>(
      "object_primitives", 1000,
      [this](const auto& subscriber) { greetPrimitivesSubscriber(subscriber); });
  save_server_ = serviceHandle().advertiseService("save_mesh", &MeshFusionNodelet::saveMesh, this);
  const auto& tsdf = config_.background_fusion.background.tsdf;
  input_ = std::make_unique<ros_interface::RgbdInput>(
      handle, config_.input, report(),
      ros_interface::RgbdInput::Callbacks{[this](const RgbdFramePtr& frame) { onFrame(frame); },
                                          [this] { onJumpBack(); }},
      plausibility::PlausibilityConfig{tsdf.min_range_m, tsdf.max_range_m});
  segmentation_subscriber_ = handle.subscribe(config_.input.segmentation_topic, 100,
                                              &MeshFusionNodelet::onSegmentation, this);
  tracks_subscriber_ = handle.subscribe("tracks", 1000, &MeshFusionNodelet::onTracks, this);
  object_follower_ = std::make_unique<ros_interface::ObjectFollower>(handle);
  watch_ = std::make_unique<ros_interface::TopicWatch>(report(), config_.input.patience_s);
  watch_->add(segmentation_subscriber_, config_.input.segmentation_topic,
              "task_scene_graph/Segmentation");
  watch_->add(tracks_subscriber_, "tracks");
}

void MeshFusionNodelet::onFrame(const RgbdFramePtr& frame) {
  background_->addFrame(frame);
  enqueueMatch(matcher_->addFrame(frame));
}

void MeshFusionNodelet::onSegmentation(const msg::SegmentationConstPtr& message) {
  watch_->noteMessage(0);
  try {
    enqueueMatch(matcher_->addSegmentation(
        ros_interface::fromMessage(message, segmentation_subscriber_.getTopic())));
  } catch (const std::exception& e) {
    report().countDropped("unusable segmentation", e.what());
  }
}

void MeshFusionNodelet::onTracks(const msg::TracksConstPtr& message) {
  watch_->noteMessage(1);
  {
    const std::lock_guard<std::mutex> lock(tracks_mutex_);
    held_tracks_.push_back({message, std::chrono::steady_clock::now()});
  }
  releaseTracks(false);
  for (const auto& track : message->finished) arrivals_.noteId(track.id);
  arrivals_.noteStamp(ros_interface::toStamp(message->header.stamp));
}

void MeshFusionNodelet::onJumpBack() {
  releaseTracks(true);
  matcher_->clear();
  const std::lock_guard<std::mutex> lock(tracks_mutex_);
  newest_match_ = {};
}

void MeshFusionNodelet::enqueueMatch(std::optional<Match> match) {
  if (!match) return;
  background_->addView(match->frame, match->segmentation);
  {
    const std::lock_guard<std::mutex> lock(tracks_mutex_);
    newest_match_ = match->frame->stamp;
    report().countDropped("object queue full", "",
                          object_worker_->push({std::move(*match), nullptr, false}));
  }
  releaseTracks(false);
}

void MeshFusionNodelet::releaseTracks(bool all) {
  const std::lock_guard<std::mutex> lock(tracks_mutex_);
  while (!held_tracks_.empty()) {
    const auto& message = held_tracks_.front().message;
    const bool is_due = ros_interface::toStamp(message->header.stamp) <= newest_match_;
    if (!all && !is_due) return;
    report().countDropped("object queue full", "", object_worker_->push({{}, message, false}));
    held_tracks_.pop_front();
  }
}

void MeshFusionNodelet::processObjects(const ObjectJob& job) {
  try {
    if (job.match.frame != nullptr) {
      objects_->addFrame(job.match.frame, alignToFrame(*job.match.frame, job.match.segmentation));
    } else if (job.tracks != nullptr) {
      const TrackedFrame tracked = ros_interface::fromMessage(*job.tracks);
      newest_tracks_ = tracked.stamp;
      objects_->submitTracks(tracked);
    }
    publishPrimitives(objects_->takePrimitives(job.waits), newest_tracks_);
    reportObjects(*objects_, report());
  } catch (const std::exception& e) {
    report().countDropped("object error", std::string("dropped tracks: ") + e.what());
  }
}

void MeshFusionNodelet::publishPrimitives(const std::vector<ObjectPrimitivePtr>& primitives,
                                          Stamp stamp) {
  if (primitives.empty()) return;
  const std::lock_guard<std::mutex> lock(primitives_mutex_);
  primitives_.insert(primitives_.end(), primitives.begin(), primitives.end());
  primitives_stamp_ = stamp;
  report().set("object primitives", std::to_string(primitives_.size()));
  primitives_publisher_.publish(
      ros_interface::toMessage(primitives, stamp, config_.input.world_frame));
}

void MeshFusionNodelet::greetPrimitivesSubscriber(
    const ros::SingleSubscriberPublisher& subscriber) {
  const std::lock_guard<std::mutex> lock(primitives_mutex_);
  if (primitives_.empty()) return;
  subscriber.publish(
      *ros_interface::toMessage(primitives_, primitives_stamp_, config_.input.world_frame));
}

void MeshFusionNodelet::check() {
  input_->check();
  watch_->check();
  background_->check();
  report().set("frames that wait for a segmentation", std::to_string(matcher_->numFrames()));
  report().set("messages that wait for the object thread", std::to_string(object_worker_->size()));
  const std::chrono::duration<double> patience(config_.input.tf_timeout_s + 1.0);
  bool is_overdue = false;
  {
    const std::lock_guard<std::mutex> lock(tracks_mutex_);
    is_overdue = !held_tracks_.empty() &&
                 std::chrono::steady_clock::now() - held_tracks_.front().arrival > patience;
  }
  if (is_overdue) releaseTracks(true);                        // their frame was dropped
  if (object_worker_->size() == 0) object_worker_->push({});  // publishes what was done meanwhile
}

msg::FinishResponse MeshFusionNodelet::finish(const msg::FinishRequest& request,
                                              Deadline deadline) {
  msg::FinishResponse response;
  const bool has_all =
      arrivals_.wait(request.last_id, ros_interface::toStamp(request.stamp), deadline);
  input_->flush();
  releaseTracks(true);
  report().countDropped("object queue full", "", object_worker_->push({{}, nullptr, true}));
  const bool is_done = background_->flush(deadline) && object_worker_->waitIdle(deadline);
  response.success = has_all && is_done;
  response.message = response.success ? "all is reconstructed"
                     : has_all        ? "still at work"
                                      : "tracks did not arrive";
  response.stamp = ros_interface::toRosTime(background_->newestFrame());
  const std::lock_guard<std::mutex> primitives_lock(primitives_mutex_);
  if (!primitives_.empty()) response.last_id = primitives_.back()->id.value;
  return response;
}

bool MeshFusionNodelet::saveMesh(std_srvs::Trigger::Request&,
                                 std_srvs::Trigger::Response& response) {
  try {
    if (config_.output.empty()) throw std::runtime_error("parameter 'output' is not set");
    const bool has_frames = background_->newestFrame() != Stamp{};
    if (!has_frames) throw std::runtime_error(report().describeInput("colour image"));
    const auto files = writeMesh(std::chrono::steady_clock::now() + std::chrono::seconds(5));
    response.message = (config_.output / files.front().name).string();
    response.success = 1;
  } catch (const std::exception& e) {
    response.message = std::string("mesh not saved: ") + e.what();
    response.success = 0;
  }
  return true;
}

std::vector<WrittenFile> MeshFusionNodelet::writeMesh(Deadline deadline) {
  const std::filesystem::path& folder = config_.output;
  std::filesystem::create_directories(folder);
  const auto objects = object_follower_->findObjects(background_->newestPlaces(), deadline);
  const std::lock_guard<std::mutex> primitives_lock(primitives_mutex_);
  return background_->writeFiles(folder, primitives_, objects);
}

}  // namespace tsg::nodelets

PLUGINLIB_EXPORT_CLASS(tsg::nodelets::MeshFusionNodelet, nodelet::Nodelet)
