// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/loops/loop_closer.h"
#include "task_scene_graph/ros/patience.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/worker.h"

namespace tsg::nodelets {

/// A loop closure of the pose graph, between the camera at two stamps.
struct LoopLine {
  Stamp a;
  Stamp b;
  bool is_accepted = false;
  double residual_m = 0.0;  ///< what of it the corrected poses leave
};

/// What loop closures say of the camera's way so far.
struct LoopResult {
  Trajectory keyframes;  ///< T_odometry_camera, corrected; the first one lies where it did
  std::vector<LoopLine> lines;
};

/// Finds places seen again by a robot that has only odometry, in a thread of its own and at a lower
/// priority than the chain's. Only keyframes are looked at; where it cannot follow, the oldest of
/// them are passed over, which costs loop closures and nothing else. Thread-safe.
class LoopStage {
 public:
  struct Options {
    loops::LoopCloserConfig config;
    std::string frame;      ///< in which poses never jump
    double period_s = 5.0;  ///< between two results, of the frames' stamps
  };
  /// Gets the newest result where poses have changed, in a thread of this object's. May block: of
  /// results that come meanwhile the newest waits.
  using OnResult = std::function<void(const LoopResult&)>;

  /// @param report  must outlive this object
  /// @throws config::ConfigError
  LoopStage(const Options& options, ros_interface::StageReport& report, OnResult on_result);
  ~LoopStage() { stop(); }

  /// A segmented frame, its pose by odometry. Never blocks for long.
  void addFrame(const RgbdFramePtr& frame, const SegmentationPtr& segmentation);
  /// There is no further frame: looks at all that waits, and hands on what is due. False if
  /// patience ended before.
  bool finish(const ros_interface::Patience& patience);
  /// Stamps have jumped back: looks at nothing any more, until restart().
  void end();
  /// Forgets all: the way begins anew.
  void restart();
  /// About once a second: lines of the diagnostics.
  void check();
  void stop();

 private:
  using Job = std::function<void()>;

  void process(const RgbdFrame& frame, const SegmentationPtr& segmentation);
  void tell();
  LoopResult makeResult() const;
  void describe();

  const Options options_;
  ros_interface::StageReport& report_;
  const OnResult on_result_;
  std::mutex mutex_;                                ///< guards the next two
  std::optional<trajectory::Keyframes> keyframes_;  ///< chosen so far; none after end()
  std::uint64_t num_passed_over_ = 0;
  std::optional<loops::LoopCloser> closer_;  ///< this and the next two: of the worker's thread
  std::optional<Stamp> last_told_;
  bool is_due_ = false;  ///< poses have changed since the last result
  ros_interface::Worker<std::shared_ptr<const LoopResult>> results_;
  ros_interface::Worker<Job> worker_;
};

}  // namespace tsg::nodelets
