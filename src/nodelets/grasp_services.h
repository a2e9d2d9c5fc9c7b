// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/id.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::nodelets {

/// Where to reach in what the camera sees now: the tracker's service `~grasp_pixel`, for
/// embeddings, in a thread of its own. Thread-safe.
class GraspServices {
 public:
  /// A segmented image that was tracked.
  struct View {
    RgbdFramePtr frame;
    SegmentationPtr segmentation;  ///< in the frame's pixels
    std::vector<TrackId> tracks;   ///< of its segments
    std::string camera_frame;
  };

  GraspServices(const ros::NodeHandle& handle, std::string world_frame);

  /// An image has come, segmented or not: by it the age of the view is told.
  void noteFrame(Stamp stamp);
  void setView(View view);
  /// Stamps start anew, or the map does.
  void forget();

 private:
  bool serve(msg::GraspPixelRequest& request, msg::GraspPixelResponse& response);
  void answer(const msg::GraspPixelRequest& request, msg::GraspPixelResponse& response) const;
  /// @throws std::runtime_error if there is none, or it is too old.
  View newestView(double max_age_s, double& age_s) const;

  const std::string world_frame_;
  mutable std::mutex mutex_;  ///< guards the three below; the view's images are immutable
  std::optional<View> view_;
  Stamp newest_stamp_;  ///< of any image
  std::chrono::steady_clock::time_point newest_arrival_;
  ros::CallbackQueue queue_;  ///< not a queue of the nodelet's, which may be gone before it
  ros::NodeHandle handle_;
  ros::ServiceServer server_;
  ros::AsyncSpinner spinner_;
};

}  // namespace tsg::nodelets
