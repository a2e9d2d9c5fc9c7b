// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "map_correction.h"
#include "task_scene_graph/mapping/tsdf_volume.h"
#include "task_scene_graph/places/place_extractor.h"
#include "task_scene_graph/ros/byte_budget.h"
#include "task_scene_graph/ros/late_subscribers.h"
#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/ros/stage_report.h"

namespace tsg::nodelets {

/// Free space and views -> the place graph, in a thread of its own: an update may take longer than
/// many frames. Thread-safe.
class PlacesStage {
 public:
  struct Options {
    places::PlacesConfig places;
    std::string world_frame;
    std::size_t max_views = 100;           ///< that wait; beyond it the oldest is dropped
    std::size_t max_view_bytes = 1 << 28;  ///< of their images; beyond it a new one is dropped
    /// Told of what is published, from the thread; may be null.
    std::function<void(const PlaceGraph&, const places::GroundPlan&)> on_map{};
  };

  /// Advertises `place_graph`, whose late subscribers get the newest graph. roscpp's own latch
  /// would give one that comes during a publish the graph before, and that for good.
  /// @param late    must be stopped before this object ends
  /// @param report  must outlive this object
  PlacesStage(ros::NodeHandle& handle, ros_interface::LateSubscribers& late, const Options& options,
              ros_interface::StageReport& report);
  ~PlacesStage() { stop(); }

  /// Asks for a graph as of `stamp`. Requests that wait become one, the newest. Never blocks.
  /// @param changed  copies of the blocks that changed since the last request
  /// @param poses  of the frames that were integrated since, in their order
  void update(mapping::TsdfVolume changed, const std::vector<places::CameraPose>& poses,
              Stamp stamp);
  /// The image embedding of a frame, for the places that it sees. Never blocks.
  /// @param num_corrections  that came before the frame: it waits until correct() has had as many
  void addView(const RgbdFramePtr& frame, const SegmentationPtr& segmentation,
               std::uint64_t num_corrections = 0);
  /// Moves all that was given before, finds the places anew, and publishes them; until then the old
  /// ones stay. Null: a correction of what is gone. Never blocks.
  void correct(const MapCorrectionPtr& correction);

  /// Waits until no request and no view waits. False if the deadline passes first.
  bool waitIdle(std::chrono::steady_clock::time_point deadline);
  /// What to go on from later. Waits for an update that is under way.
  std::shared_ptr<const places::PlaceMemory> memory() const;
  /// Goes on from there instead, and publishes the graph. What waits is dropped. Does not wait.
  void restore(std::shared_ptr<const places::PlaceMemory> memory, double voxel_size_m);
  /// Forgets all places and what waits, and publishes an empty graph.
  void clear(Stamp stamp);
  /// Drops what waits and joins the thread.
  void stop();

  /// Number of the newest graph that was published, from 1; 0 if there is none.
  std::uint64_t sequence() const { return sequence_; }
  std::size_t numWaitingViews() const;

 private:
  struct Request {
    mapping::TsdfVolume changed;
    std::vector<places::CameraPose> poses;
    Stamp stamp;
  };
  struct View {
    RgbdFramePtr frame;
    SegmentationPtr segmentation;
    ros_interface::ByteBudget::Share share;
    std::uint64_t num_corrections = 0;
  };
  /// What the thread does next.
  struct Work {
    bool is_cleared = false;  ///< before the rest
    Stamp clear_stamp;
    std::shared_ptr<const places::PlaceMemory> memory;  ///< before the rest; may be null
    double voxel_size_m = 0.0;                          ///< of it
    std::deque<View> views;                             ///< before the request
    std::optional<Request> request;
    MapCorrectionPtr correction;  ///< after the rest; may be null

    bool isEmpty() const {
      return !is_cleared && memory == nullptr && views.empty() && !request && correction == nullptr;
    }
  };

  void run();
  void process(const Work& work, std::uint64_t num_clears);
  void update(const Request& request);
  void follow(const MapCorrection& correction);
  bool isIdle() const { return corrected_.empty() && work_.isEmpty() && !is_busy_; }
  void forgetWork();
  std::size_t countViews() const;
  void publish(const PlaceGraph& graph, std::uint64_t num_clears);
  void sendNewest(ros_interface::PartSender& sender);

  const Options options_;
  ros_interface::StageReport& report_;
  std::mutex publish_mutex_;  ///< keeps late subscribers and changes in order; for the next
  msg::PlaceGraphConstPtr newest_sent_;  ///< null before the first one
  ros::Publisher publisher_;
  ros_interface::ByteBudget view_budget_;
  mutable std::mutex extractor_mutex_;  ///< guards the next; held by the thread during an update
  std::unique_ptr<places::PlaceExtractor> extractor_;
  mutable std::mutex mutex_;  ///< guards all below; never held during an update
  std::condition_variable changed_;
  std::deque<Work> corrected_;  ///< up to a correction each, before work_
  Work work_;
  std::deque<View> early_views_;  ///< of after a correction that is still to come
  std::uint64_t num_corrections_ = 0;
  std::uint64_t num_clears_ = 0;
  std::atomic<std::uint64_t> sequence_{0};
  bool is_busy_ = false;
  bool is_stopped_ = false;
  std::thread thread_;
};

}  // namespace tsg::nodelets
