// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "map_correction.h"
#include "occupancy_stage.h"
#include "places_stage.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/map/map.h"
#include "task_scene_graph/pipeline/background_fusion.h"
#include "task_scene_graph/ros/byte_budget.h"
#include "task_scene_graph/ros/camera_publisher.h"
#include "task_scene_graph/ros/late_subscribers.h"
#include "task_scene_graph/ros/mesh_publisher.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/worker.h"

namespace tsg::nodelets {

struct BackgroundStageOptions {
  pipeline::BackgroundFusionConfig fusion;
  std::string world_frame;
  double mesh_period_s = 1.0;
  double octomap_period_s = 1.0;
  std::size_t queue_size = 100;             ///< frames, and views, that wait
  std::size_t max_queue_bytes = 512000000;  ///< of the images of either
  /// Told of new places and their ground plan, from a thread of this stage; may be null.
  std::function<void(const PlaceGraph&, const places::GroundPlan&)> on_map{};
};

/// Every frame -> background mesh, places, occupancy map: their threads, their topics.
///
/// One thread integrates depth. It hands immutable tables of meshes to the mesh publisher's thread
/// and copies of changed free space to the places' thread, and waits for neither; late subscribers
/// have threads of their own. Thread-safe.
class BackgroundStage {
 public:
  /// Advertises `mesh`, `mesh_blocks`, `place_graph`, `camera_markers` and, where enabled,
  /// `octomap...`.
  /// @param report  must outlive this object
  BackgroundStage(ros::NodeHandle& handle, const BackgroundStageOptions& options,
                  ros_interface::StageReport& report);
  ~BackgroundStage() { stop(); }

  /// A frame to integrate. Never blocks for long.
  void addFrame(const RgbdFramePtr& frame);
  /// Moves all that was given before: mesh, trajectory, places, occupancy map. Volumes begin anew,
  /// as after restore(); what they showed stays where nothing is seen anew. Frames given meanwhile
  /// wait; the old map can be read until the new one is there. Never blocks for long.
  void correct(const MapCorrectionPtr& correction);
  /// The image embedding of a frame, for the places that it sees. Never blocks for long.
  void addView(const RgbdFramePtr& frame, const SegmentationPtr& segmentation);

  /// About once a second: lines of the diagnostics.
  void check();
  /// Waits until what waits now is integrated and published, due or not; what is done when patience
  /// ends is published. @returns what is missing, one line each.
  std::vector<std::string> flush(const ros_interface::Patience& patience);
  /// Begins anew: drops what waits, clears volumes, mesh, places and occupancy map, and tells
  /// subscribers. Frames added from now on are of the new map.
  void reset();
  /// Drops what waits and joins all threads. Nothing may be added from now on.
  void stop();

  /// Goes on from a map of before instead, and tells subscribers. Frames added from now on are of
  /// the new map. @throws std::runtime_error as mapping::BackgroundMap::restore(); nothing has
  /// changed then.
  void restore(const map::Map& map);
  /// Waits until the places are found anew. False if the deadline passes first.
  bool waitForPlaces(std::chrono::steady_clock::time_point deadline) {
    return places_.waitIdle(deadline);
  }

  /// Stamp of the newest integrated frame; 0 if there is none.
  Stamp firstFrame() const;  ///< of the trajectory; 0 without one
  Stamp newestFrame() const;
  /// Number of the newest place graph that was published; 0 if there is none.
  std::uint64_t placeSequence() const { return places_.sequence(); }

  /// What of the map this stage knows, as of now: mesh, trajectory, free space, occupancy map.
  /// @throws std::runtime_error as mapping::MeshArchive::Record::load().
  map::Map makeMap();

 private:
  struct Job {
    RgbdFramePtr frame;
    ros_interface::ByteBudget::Share share;
    std::uint64_t num_resets = 0;
    MapCorrectionPtr correction;  ///< instead of a frame
  };

  void process(const Job& job);
  void integrate(const Job& job);
  void follow(const Job& job);
  mapping::MeshTable takeMeshes(const Job& job);
  std::vector<mapping::BlockMesh> moveMeshes(const std::vector<mapping::BlockMesh>& blocks,
                                             const MapCorrection& correction) const;
  void exchange(std::unique_ptr<pipeline::BackgroundFusion> fusion,
                const mapping::MeshUpdate& update, const MapCorrection& correction);
  void publishMesh(const mapping::MeshUpdate& update);
  void requestPlaces();

  const BackgroundStageOptions options_;
  ros_interface::StageReport& report_;
  ros_interface::LateSubscribers late_;
  ros_interface::ByteBudget budget_;
  std::atomic<std::uint64_t> num_resets_{0};       ///< frames of before a reset are not integrated
  std::atomic<std::uint64_t> num_corrections_{0};  ///< given; views say which came before them
  /// Guards all below up to the publishers. Held while a frame is integrated and while changed
  /// blocks are meshed, both O(what the camera sees); never while anything is sent, written or
  /// waited for.
  mutable std::mutex mutex_;
  std::unique_ptr<pipeline::BackgroundFusion> fusion_;
  Stamp newest_frame_;
  Trajectory trajectory_;                      ///< of the camera, in all frames
  std::vector<places::CameraPose> new_poses_;  ///< since the places were last asked for
  std::optional<Stamp> last_mesh_;
  std::optional<Stamp> last_places_;
  ros_interface::MeshPublisher mesh_publisher_;
  ros_interface::CameraPublisher camera_publisher_;
  PlacesStage places_;
  std::unique_ptr<OccupancyStage> occupancy_;  ///< null if off
  ros_interface::Worker<Job> worker_;
};

}  // namespace tsg::nodelets
