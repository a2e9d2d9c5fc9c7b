// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/plausibility/input_plausibility.h"
#include "task_scene_graph/ros/input_config.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/topic_watch.h"

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
    std::function<void()> on_jump_back;  ///< from the queue of the node handle; must not throw
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
  /// To be called about once a second from the queue of the node handle.
  void check();
  /// Hands on everything that waits for a partner, as if no image would follow. From any thread.
  void flush();
  /// Where other topics of the same stage are watched, so that all of it speaks in one line; of the
  /// queue of the node handle. check() looks at them, too.
  TopicWatch& watch();
  /// Frame id of the newest colour image's camera.
  std::string cameraFrame() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tsg::ros_interface
