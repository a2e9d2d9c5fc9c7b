// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "map_correction.h"
#include "task_scene_graph/pipeline/object_fusion.h"
#include "task_scene_graph/ros/arrivals.h"
#include "task_scene_graph/ros/epoch.h"
#include "task_scene_graph/ros/late_subscribers.h"
#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/worker.h"

namespace tsg::nodelets {

struct ObjectStageOptions {
  pipeline::ObjectFusionConfig fusion;
  std::string world_frame;
  std::size_t queue_size = 1000;  ///< segmented frames that wait
  double frame_patience_s = 2.0;  ///< for the frame of which the tracker speaks
};

/// Segmented frames and what the tracker says of them -> object primitives: their thread, their
/// topic. Frames may drop, the tracker's messages never do. Thread-safe.
class ObjectStage {
 public:
  /// Advertises `object_primitives`.
  /// @param report  must outlive this object
  ObjectStage(ros::NodeHandle& handle, const ObjectStageOptions& options,
              ros_interface::StageReport& report);

  /// A segmented frame. Never blocks for long.
  void addFrame(const RgbdFramePtr& frame, const SegmentationPtr& segmentation);
  /// Waits for the frame that the tracker speaks of, if it is on its way.
  void addTracks(const msg::TracksConstPtr& message);
  /// Moves all that was given before, after what is being reconstructed is done: primitives, which
  /// are published anew with their ids, and the frames that live tracks need. Never blocks.
  void correct(const MapCorrectionPtr& correction);
  /// Stamps have jumped back.
  void startEpoch();

  /// About once a second: publishes what is done, lines of the diagnostics.
  void check();
  /// Reconstructs and publishes what the stage has been given so far. Says in `response` what it
  /// has, and what is missing.
  void flush(const msg::FlushRequest& request, const ros_interface::Patience& patience,
             msg::FlushResponse& response);
  /// Forgets all, and tells it to who listens.
  void reset();
  /// Begins with these, before anybody listens: late subscribers are sent them.
  void begin(std::vector<ObjectPrimitivePtr> primitives);
  /// Goes on from these instead of what there is, and tells it to who listens. Does not wait.
  void restore(std::vector<ObjectPrimitivePtr> primitives);
  /// Waits until all that was asked for is done and published. False as waitPatiently().
  bool waitHandled(const ros_interface::Patience& patience) {
    return worker_.waitHandled(patience);
  }
  /// Number of the newest message.
  std::uint64_t sequence() const { return sequence_; }
  /// Drops what waits and joins the thread. Nothing may be added from now on.
  void stop();

  /// All there are, ascending by id.
  std::vector<ObjectPrimitivePtr> primitives() const;

 private:
  using Job = std::function<void()>;
  struct HeldTracks {
    msg::TracksConstPtr message;
    std::uint32_t epoch = 1;
    std::chrono::steady_clock::time_point arrival;
  };

  bool isDue(const HeldTracks& held, std::chrono::steady_clock::time_point now) const;
  void releaseTracks(bool all);
  void waitForTracks(std::uint64_t sequence, const ros_interface::Patience& patience,
                     msg::FlushResponse& response);
  void waitForReconstruction(const ros_interface::Patience& patience, msg::FlushResponse& response);
  void process(const Job& job);
  void publish(bool is_reset = false, bool wait = false);
  void follow(const MapCorrection& correction);
  /// @param are_moved  they take the place of those of their ids
  void send(const std::vector<ObjectPrimitivePtr>& primitives, bool are_moved = false);
  /// Numbers a message and sends it to all.
  void publishNext(const msg::ObjectPrimitivesPtr& message);
  void store(const pipeline::ObjectUpdate& update);
  void sendAll(ros_interface::PartSender& sender) const;

  const ObjectStageOptions options_;
  ros_interface::StageReport& report_;
  ros_interface::Arrivals arrivals_;
  ros_interface::EpochFollower epoch_;  ///< of the tracker's messages
  std::mutex tracks_mutex_;             ///< guards the two below
  std::deque<HeldTracks> held_tracks_;
  Stamp newest_frame_;             ///< that was segmented
  pipeline::ObjectFusion fusion_;  ///< the worker's own, as the next
  Stamp newest_tracks_;
  mutable std::mutex primitives_mutex_;
  std::map<PrimitiveId, ObjectPrimitivePtr> primitives_;
  mutable std::mutex sequence_mutex_;       ///< held while a message is numbered and sent
  std::atomic<std::uint64_t> sequence_{0};  ///< of the newest message
  ros_interface::LateSubscribers late_;
  ros::Publisher publisher_;
  ros_interface::Worker<Job> worker_;
};

}  // namespace tsg::nodelets
