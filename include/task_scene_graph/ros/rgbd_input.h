// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>
#include <tf2/buffer_core.h>
#include <topic_tools/shape_shifter.h>

#include <boost/signals2/connection.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/ros/frame_assembler.h"
#include "task_scene_graph/ros/image_subscriber.h"
#include "task_scene_graph/ros/input_config.h"
#include "task_scene_graph/ros/input_plausibility_report.h"
#include "task_scene_graph/ros/pose_source.h"
#include "task_scene_graph/ros/pose_waiter.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/topic_watch.h"
#include "task_scene_graph/ros/transform_feed.h"
#include "task_scene_graph/ros/transform_history.h"

namespace tsg::ros_interface {

/// Throws what RgbdInput's constructor would. A nodelet calls it before it advertises anything: one
/// that fails afterwards is destroyed after its queues, and takes the process along.
/// @throws config::ConfigError, InputError, std::runtime_error naming the parameter or the file.
void checkInputFiles(const InputConfig& config);

/// Subscribes to colour, depth and camera_info, puts together what belongs together
/// (FrameAssembler), and looks up the camera's pose at the image's stamp, in tf or on a topic of
/// poses. Pixels are not copied: frames borrow the messages.
///
/// What cannot be used is dropped, counted and named in the report. When stamps jump back by more
/// than a second (a bag in a loop), tf's memory is cleared and the frames start anew.
class RgbdInput {
 public:
  struct Callbacks {
    std::function<void(RgbdFramePtr)> on_frame;  ///< from a thread of this object; must not throw
    std::function<void()> on_jump_back;          ///< from the subscribers' queue; must not throw
  };

  /// Subscribes at once; `report` must live longer.
  /// @param plausibility  where given, the report says what looks wrong with the input; one stage
  /// of a chain is enough
  /// @throws config::ConfigError, InputError, std::runtime_error for files that cannot be read.
  RgbdInput(const ::ros::NodeHandle& handle, const InputConfig& config, StageReport& report,
            Callbacks callbacks,
            const std::optional<plausibility::PlausibilityConfig>& plausibility = std::nullopt);
  ~RgbdInput();

  /// Names silent topics and stamps that never match; decides on images that have waited for long.
  /// To be called about once a second from the subscribers' queue.
  void check();
  /// Hands on everything that waits for a partner, as if no image would follow. From any thread.
  void flush();
  /// Frame id of the newest colour image's camera.
  std::string cameraFrame() const;

 private:
  FrameAssembler::Callbacks makeAssemblerCallbacks();
  InputTopics resolveTopics(const ::ros::NodeHandle& handle) const;
  void subscribe(const ::ros::NodeHandle& handle);
  void subscribeCameraInfo(::ros::NodeHandle handle);
  void subscribePoses(::ros::NodeHandle handle);
  void addPose(const topic_tools::ShapeShifter& message);
  void reportFindings();
  void lookForCompressed(ImageSubscriber& image, std::size_t number);
  void jumpBack();

  const InputConfig config_;
  StageReport& report_;
  const Callbacks callbacks_;
  const std::unique_ptr<InputPlausibilityReport> plausibility_;  ///< may be null
  TopicWatch watch_;
  tf2::BufferCore tf_buffer_;
  TransformHistory tf_history_;
  PoseSource poses_;
  PoseWaiter pose_waiter_;
  boost::signals2::scoped_connection tf_changed_;
  std::unique_ptr<TransformFeed> tf_feed_;  ///< its thread calls those above
  mutable std::mutex mutex_;                ///< guards the two below
  std::string camera_frame_;
  std::unique_ptr<FrameAssembler> assembler_;
  std::uint64_t num_colors_at_check_ = 0;
  int num_quiet_checks_ = 0;
  std::chrono::steady_clock::time_point newest_findings_;
  std::optional<ImageSubscriber> color_;
  std::optional<ImageSubscriber> depth_;
  ::ros::Subscriber info_;
  ::ros::Subscriber pose_;
};

}  // namespace tsg::ros_interface
