// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <pluginlib/class_list_macros.hpp>

#include "grasp_services.h"
#include "stage_nodelet.h"
#include "task_scene_graph/plausibility/embedding_checks.h"
#include "task_scene_graph/ros/arrivals.h"
#include "task_scene_graph/ros/epoch.h"
#include "task_scene_graph/ros/frame_matcher.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/rgbd_input.h"
#include "task_scene_graph/ros/worker.h"
#include "task_scene_graph/tracking/tracker.h"
#include "tracker_config.h"

namespace tsg::nodelets {

/// Images and segmentations of the same stamp -> `tracks`.
class TrackerNodelet : public StageNodelet {
 public:
  ~TrackerNodelet() override {
    stopCallbacks();
    if (worker_ != nullptr) worker_->stop();  // it uses the input, which dies first
  }

 private:
  /// A segmented frame may drop, what is asked of the tracker besides never does.
  enum class Request { kTrack, kDescribe, kEnd, kStartEpoch, kReset };
  struct Job {
    ros_interface::FrameMatcher::Match match;
    Request request = Request::kTrack;
  };

  void start() override;
  void check() override;
  msg::FlushResponse flush(const msg::FlushRequest& request,
                           const ros_interface::Patience& patience) override;
  std::string reset() override;

  void onSegmentation(const msg::SegmentationConstPtr& message);
  void enqueue(std::optional<ros_interface::FrameMatcher::Match> match);
  void process(const Job& job);
  void onFrame(RgbdFramePtr frame);
  void onJumpBack();
  void track(const ros_interface::FrameMatcher::Match& match);
  void describe();
  void finish();
  void publish(const TrackedFrame& tracked);
  void shiftIds(TrackedFrame& tracked);
  void reportCounters();
  void reportFindings();
  void startAnew();
  void checkIdle();

  TrackerNodeletConfig config_;
  std::unique_ptr<tracking::Tracker> tracker_;
  std::uint64_t id_offset_ = 0;  ///< ids stay unique when the tracker starts anew
  std::uint64_t largest_id_ = 0;
  std::uint32_t epoch_ = 1;  ///< of the tracker's frames
  Stamp newest_;             ///< stamp that was tracked
  ros_interface::EpochFollower segmentations_epoch_;
  std::atomic<std::uint64_t> sequence_{0};  ///< of the newest message
  std::atomic<std::size_t> num_live_{0};
  std::atomic<std::uint64_t> num_dropped_{0};  ///< segmented frames, under load
  std::uint64_t processed_at_check_ = 0;
  std::chrono::steady_clock::time_point last_progress_ = std::chrono::steady_clock::now();
  ros_interface::Arrivals segmentations_;
  ros::Publisher publisher_;
  std::unique_ptr<ros_interface::FrameMatcher> matcher_;
  std::unique_ptr<GraspServices> grasp_;
  std::unique_ptr<ros_interface::Worker<Job>> worker_;
  std::unique_ptr<ros_interface::RgbdInput> input_;
  ros::Subscriber subscriber_;
  std::size_t segmentation_topic_ = 0;  ///< its number among those that are watched
};

void TrackerNodelet::start() {
  config_ = loadConfig<TrackerNodeletConfig>();
  ros_interface::checkInputFiles(config_.input);
  tracker_ = std::make_unique<tracking::Tracker>(config_.tracker);
  matcher_ =
      std::make_unique<ros_interface::FrameMatcher>(static_cast<std::size_t>(config_.frame_cache));
  publisher_ = topicHandle().advertise<msg::Tracks>("tracks", 0);  // no bound: none may drop
  grasp_ = std::make_unique<GraspServices>(getPrivateNodeHandle(), config_.input.world_frame);
  worker_ = std::make_unique<ros_interface::Worker<Job>>(
      static_cast<std::size_t>(config_.queue_size), [this](const Job& job) { process(job); });
  input_ = std::make_unique<ros_interface::RgbdInput>(
      topicHandle(), config_.input, report(),
      ros_interface::RgbdInput::Callbacks{[this](RgbdFramePtr frame) { onFrame(std::move(frame)); },
                                          [this] { onJumpBack(); }});
  subscriber_ = topicHandle().subscribe(config_.input.segmentation_topic, 100,
                                        &TrackerNodelet::onSegmentation, this);
  segmentation_topic_ = input_->watch().add(subscriber_, config_.input.segmentation_topic,
                                            "task_scene_graph/Segmentation");
}

void TrackerNodelet::onFrame(RgbdFramePtr frame) {
  if (isPaused()) return;
  grasp_->noteFrame(frame->stamp);
  enqueue(matcher_->addFrame(std::move(frame)));
}

void TrackerNodelet::onJumpBack() {
  segmentations_epoch_.startEpoch();
  matcher_->startEpoch(segmentations_epoch_.epoch());
  worker_->pushOrder({{}, Request::kStartEpoch});
}

void TrackerNodelet::onSegmentation(const msg::SegmentationConstPtr& message) {
  input_->watch().noteMessage(segmentation_topic_);
  try {
    auto segmentation = ros_interface::fromMessage(message, subscriber_.getTopic());
    const std::uint32_t epoch = segmentations_epoch_.follow(message->epoch, segmentation->stamp);
    enqueue(matcher_->addSegmentation(std::move(segmentation), epoch));
  } catch (const std::exception& e) {
    report().countDropped("unusable segmentation", e.what());
  }
  segmentations_.note(message->sequence);
}

void TrackerNodelet::enqueue(std::optional<ros_interface::FrameMatcher::Match> match) {
  if (!match) return;
  const std::size_t dropped = worker_->push({std::move(*match), Request::kTrack});
  num_dropped_ += dropped;
  report().countDropped("queue full", "", dropped);
}

void TrackerNodelet::process(const Job& job) {
  try {
    switch (job.request) {
      case Request::kTrack:
        track(job.match);
        break;
      case Request::kDescribe:
        describe();
        break;
      case Request::kEnd:
        finish();
        break;
      case Request::kStartEpoch:
        finish();
        startAnew();
        ++epoch_;
        break;
      case Request::kReset:
        startAnew();
        publish({});
        break;
    }
    reportCounters();
    reportFindings();
  } catch (const std::exception& e) {
    report().countDropped("error", std::string("dropped a frame: ") + e.what());
  }
}

void TrackerNodelet::track(const ros_interface::FrameMatcher::Match& match) {
  const ros_interface::StageTimer timer;
  const auto before = tracker_->counters();
  const SegmentationPtr aligned = alignToFrame(*match.frame, match.segmentation);
  TrackedFrame tracked = tracker_->update(*match.frame, *aligned);
  tracked.provisional = tracker_->describeLiveTracks(false);
  const auto& counters = tracker_->counters();
  newest_ = match.frame->stamp;
  shiftIds(tracked);
  publish(tracked);
  if (counters.invalid_frames > before.invalid_frames) {
    report().countDropped("unusable for the tracker",
                          "the tracker refused a frame: its label image, depth or camera differ in "
                          "size, its pose lies out of the grid, or an embedding is not finite or "
                          "of another size than before");
  } else if (counters.out_of_order_frames > before.out_of_order_frames) {
    report().countDropped("not later than the frame before");
  } else {
    grasp_->setView({match.frame, aligned, tracked.segment_tracks, input_->cameraFrame()});
    report().countProcessed(timer.elapsedMs());
  }
}

void TrackerNodelet::describe() {
  TrackedFrame tracked;
  tracked.stamp = newest_;
  tracked.provisional = tracker_->describeLiveTracks(true);
  tracked.live = tracker_->liveIds();
  tracked.is_snapshot = true;
  shiftIds(tracked);
  publish(tracked);
}

void TrackerNodelet::finish() {
  TrackedFrame tracked = tracker_->finish();
  shiftIds(tracked);
  publish(tracked);
}

void TrackerNodelet::shiftIds(TrackedFrame& tracked) {
  const auto shift = [this](TrackId& id) {
    if (id.isValid()) id.value += id_offset_;
    largest_id_ = std::max(largest_id_, id.value);
  };
  for (auto& id : tracked.segment_tracks) shift(id);
  for (auto& id : tracked.live) shift(id);
  for (auto& track : tracked.finished) shift(track.id);
  for (auto& track : tracked.provisional) shift(track.id);
}

void TrackerNodelet::publish(const TrackedFrame& tracked) {
  num_live_ = tracked.live.size();
  const msg::TracksPtr message = ros_interface::toMessage(tracked, input_->cameraFrame());
  message->sequence = ++sequence_;
  message->epoch = epoch_;
  publisher_.publish(message);
}

void TrackerNodelet::reportCounters() {
  const tracking::TrackerCounters& counters = tracker_->counters();
  report().set("live tracks", std::to_string(tracker_->numLiveTracks()));
  report().set("tracks that ended", std::to_string(counters.tracks_finished));
  report().set("tracks dropped: too few observations", std::to_string(counters.tracks_dropped));
  report().set("segments", std::to_string(counters.segments));
  report().set("segments ignored: too small", std::to_string(counters.small_segments));
  report().set("segments ignored: too large", std::to_string(counters.large_segments));
  report().set("segments that continued a track", std::to_string(counters.associations));
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
  grasp_->forget();
}

void TrackerNodelet::check() {
  input_->check();
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
  if (num_live_ == 0 || config_.idle_finish_s <= 0.0 || idle.count() < config_.idle_finish_s)
    return;
  last_progress_ = now;
  worker_->pushOrder({{}, Request::kEnd});
}

msg::FlushResponse TrackerNodelet::flush(const msg::FlushRequest& request,
                                         const ros_interface::Patience& patience) {
  msg::FlushResponse response;
  if (!segmentations_.wait(request.sequence, patience)) {
    response.missing.push_back("segmentations have not arrived");
  }
  input_->flush();
  const bool ends = request.mode == msg::FlushRequest::END;
  worker_->pushOrder({{}, ends ? Request::kEnd : Request::kDescribe});
  if (!worker_->waitHandled(patience)) {
    response.missing.push_back(std::to_string(worker_->size()) + " frames are not yet tracked");
  }
  response.sequence = sequence_;
  response.content = std::to_string(num_live_) + " live tracks";
  if (num_dropped_ > 0) {
    response.content += ", " + std::to_string(num_dropped_) +
                        " segmented frames were dropped under load since the start";
  }
  return response;
}

std::string TrackerNodelet::reset() {
  const std::size_t num_live = num_live_;
  matcher_->clear();
  worker_->pushOrder({{}, Request::kReset});
  worker_->waitHandled(ros_interface::Patience::from(10.0, 5.0));
  return std::to_string(num_live) + " live tracks are forgotten";
}

}  // namespace tsg::nodelets

PLUGINLIB_EXPORT_CLASS(tsg::nodelets::TrackerNodelet, nodelet::Nodelet)
