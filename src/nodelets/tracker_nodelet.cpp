// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <pluginlib/class_list_macros.hpp>

#include "stage_nodelet.h"
#include "task_scene_graph/plausibility/embedding_checks.h"
#include "task_scene_graph/ros/arrivals.h"
#include "task_scene_graph/ros/frame_matcher.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/rgbd_input.h"
#include "task_scene_graph/ros/topic_watch.h"
#include "task_scene_graph/ros/worker.h"
#include "task_scene_graph/tracking/tracker.h"
#include "tracker_config.h"

namespace tsg::nodelets {

/// Images and segmentations of the same stamp -> `tracks`.
class TrackerNodelet : public StageNodelet {
 public:
  ~TrackerNodelet() override {
    stopServices();
    if (worker_ != nullptr) worker_->stop();  // it uses the input, which dies first
  }

 private:
  /// A segmented frame, or, without one, the order to end all live tracks.
  struct Job {
    ros_interface::FrameMatcher::Match match;
    bool is_new_start = false;  ///< time jumped back: stamps start anew
  };

  void start() override;
  void check() override;
  msg::FinishResponse finish(const msg::FinishRequest& request, Deadline deadline) override;

  void onSegmentation(const msg::SegmentationConstPtr& message);
  void enqueue(std::optional<ros_interface::FrameMatcher::Match> match);
  void process(const Job& job);
  void publish(TrackedFrame tracked);
  void reportFindings();
  void startAnew();
  void checkIdle();

  TrackerNodeletConfig config_;
  std::unique_ptr<tracking::Tracker> tracker_;
  std::uint64_t id_offset_ = 0;  ///< ids stay unique when the tracker starts anew
  std::uint64_t largest_id_ = 0;
  std::mutex published_mutex_;
  std::uint64_t last_finished_id_ = 0;
  Stamp last_stamp_;
  std::atomic<bool> has_live_tracks_{false};
  std::uint64_t processed_at_check_ = 0;
  std::chrono::steady_clock::time_point last_progress_ = std::chrono::steady_clock::now();
  ros_interface::Arrivals segmentations_;
  ros::Publisher publisher_;
  std::unique_ptr<ros_interface::FrameMatcher> matcher_;
  std::unique_ptr<ros_interface::TopicWatch> watch_;
  std::unique_ptr<ros_interface::Worker<Job>> worker_;
  std::unique_ptr<ros_interface::RgbdInput> input_;
  ros::Subscriber subscriber_;
};

void TrackerNodelet::start() {
  config_ = loadConfig<TrackerNodeletConfig>();
  ros_interface::checkInputFiles(config_.input);
  tracker_ = std::make_unique<tracking::Tracker>(config_.tracker);
  matcher_ =
      std::make_unique<ros_interface::FrameMatcher>(static_cast<std::size_t>(config_.frame_cache));
  publisher_ = getNodeHandle().advertise<msg::Tracks>("tracks", 1000);
  worker_ = std::make_unique<ros_interface::Worker<Job>>(
      static_cast<std::size_t>(config_.queue_size), [this](const Job& job) { process(job); });
  input_ = std::make_unique<ros_interface::RgbdInput>(
      getNodeHandle(), config_.input, report(),
      ros_interface::RgbdInput::Callbacks{
          [this](RgbdFramePtr frame) { enqueue(matcher_->addFrame(std::move(frame))); },
          [this] {
            matcher_->clear();
            worker_->push({{}, true});
          }});
  subscriber_ = getNodeHandle().subscribe(config_.input.segmentation_topic, 100,
                                          &TrackerNodelet::onSegmentation, this);
  watch_ = std::make_unique<ros_interface::TopicWatch>(report(), config_.input.patience_s);
  watch_->add(subscriber_, config_.input.segmentation_topic, "task_scene_graph/Segmentation");
}

void TrackerNodelet::onSegmentation(const msg::SegmentationConstPtr& message) {
  watch_->noteMessage(0);
  try {
    auto segmentation = ros_interface::fromMessage(message, subscriber_.getTopic());
    enqueue(matcher_->addSegmentation(std::move(segmentation)));
  } catch (const std::exception& e) {
    report().countDropped("unusable segmentation", e.what());
  }
  segmentations_.noteStamp(ros_interface::toStamp(message->header.stamp));
}

void TrackerNodelet::enqueue(std::optional<ros_interface::FrameMatcher::Match> match) {
  if (!match) return;
  report().countDropped("queue full", "", worker_->push({std::move(*match), false}));
}

void TrackerNodelet::process(const Job& job) {
  try {
    const ros_interface::StageTimer timer;
    const auto& [frame, segmentation] = job.match;
    publish(frame != nullptr ? tracker_->update(*frame, *alignToFrame(*frame, segmentation))
                             : tracker_->finish());
    if (frame != nullptr) report().countProcessed(timer.elapsedMs());
    reportFindings();
    if (job.is_new_start) startAnew();
  } catch (const std::exception& e) {
    report().countDropped("error", std::string("dropped a frame: ") + e.what());
  }
}

void TrackerNodelet::publish(TrackedFrame tracked) {
  const auto shift = [this](TrackId& id) {
    if (id.isValid()) id.value += id_offset_;
    largest_id_ = std::max(largest_id_, id.value);
  };
  for (auto& id : tracked.segment_tracks) shift(id);
  for (auto& id : tracked.live) shift(id);
  for (auto& track : tracked.finished) shift(track.id);
  has_live_tracks_ = !tracked.live.empty();
  publisher_.publish(ros_interface::toMessage(tracked, input_->cameraFrame()));
  const std::lock_guard<std::mutex> lock(published_mutex_);
  if (!tracked.finished.empty()) last_finished_id_ = tracked.finished.back().id.value;
  last_stamp_ = tracked.stamp;
}

void TrackerNodelet::reportFindings() {
  std::map<std::string, std::string> findings;
  if (const auto finding = plausibility::checkTracker(tracker_->counters(), config_.tracker)) {
    findings.emplace(finding->check, plausibility::toText(*finding));
  }
  report().setFindings(std::move(findings));
}

void TrackerNodelet::startAnew() {
  tracker_ = std::make_unique<tracking::Tracker>(config_.tracker);
  id_offset_ = largest_id_;
}

void TrackerNodelet::check() {
  input_->check();
  watch_->check();
  checkIdle();
  report().set("frames that wait for a segmentation", std::to_string(matcher_->numFrames()));
  report().set("segmentations without a frame",
               std::to_string(matcher_->numUnmatchedSegmentations()));
}

void TrackerNodelet::checkIdle() {
  const auto now = std::chrono::steady_clock::now();
  const std::uint64_t processed = report().processed();
  if (processed != processed_at_check_ || config_.idle_finish_s <= 0.0) last_progress_ = now;
  processed_at_check_ = processed;
  const std::chrono::duration<double> idle = now - last_progress_;
  if (!has_live_tracks_ || idle.count() < config_.idle_finish_s) return;
  last_progress_ = now;
  worker_->push({});
}

msg::FinishResponse TrackerNodelet::finish(const msg::FinishRequest& request, Deadline deadline) {
  const bool is_complete = segmentations_.wait(0, ros_interface::toStamp(request.stamp), deadline);
  input_->flush();
  worker_->push({});
  msg::FinishResponse response;
  response.success = is_complete && worker_->waitIdle(deadline);
  response.message = response.success ? "all tracks have ended" : "segmentations did not arrive";
  const std::lock_guard<std::mutex> lock(published_mutex_);
  response.last_id = last_finished_id_;
  response.stamp = ros_interface::toRosTime(last_stamp_);
  return response;
}

}  // namespace tsg::nodelets

PLUGINLIB_EXPORT_CLASS(tsg::nodelets::TrackerNodelet, nodelet::Nodelet)
