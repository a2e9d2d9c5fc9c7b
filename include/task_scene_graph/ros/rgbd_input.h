// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <message_filters/sync_policies/approximate_time.h>
#include <message_filters/sync_policies/exact_time.h>
#include <message_filters/synchronizer.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <tf2_ros/transform_listener.h>

#include <functional>
#include <memory>
#include <string>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/ros/pose_waiter.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/stamp_order.h"
#include "task_scene_graph/ros/topic_watch.h"

namespace tsg::ros_interface {

/// Group `input` of the nodelets that take RGB-D images.
struct InputConfig {
  std::string world_frame = "world";
  std::string camera_frame;
  double sync_tolerance_s = 0.02;
  int queue_size = 60;
  double tf_timeout_s = 1.0;
  double patience_s = 5.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("world_frame", self.world_frame, {}, "", "tf frame in which the map is built");
    v.field("camera_frame", self.camera_frame, {}, "",
            "tf frame of the camera (optical: x right, z forward); empty = that of the images");
    v.field("sync_tolerance_s", self.sync_tolerance_s, {0.0, 1.0}, "s",
            "colour, depth and camera_info belong together if their stamps differ by no more; "
            "0 = equal stamps only");
    v.field("queue_size", self.queue_size, {1, 10000}, "messages",
            "how many messages of a topic may wait for the others");
    v.field("tf_timeout_s", self.tf_timeout_s, {0.0, 60.0}, "s",
            "how long an image waits for the camera's pose before it is dropped");
    v.field("patience_s", self.patience_s, {0.1, 3600.0}, "s",
            "a topic that is silent for so long (wall time) is named in a warning");
  }
};

/// Subscribes to `camera/color/image_raw`, `camera/color/camera_info` and
/// `camera/aligned_depth_to_color/image_raw`, puts together what belongs together, and looks up the
/// camera's pose in tf at the image's stamp. Pixels are not copied: frames borrow the messages.
///
/// What cannot be used is dropped, counted and named in the report: wrong encodings, sizes that
/// differ, intrinsics that are not finite, missing transforms, stamps that repeat or go back. When
/// stamps jump back by more than a second (a bag in a loop), tf's memory is cleared and the frames
/// start anew.
class RgbdInput {
 public:
  struct Callbacks {
    std::function<void(RgbdFramePtr)> on_frame;  ///< from a thread of this object; must not throw
    std::function<void()> on_jump_back;          ///< from the subscribers' queue; must not throw
  };

  /// Subscribes at once; `report` must live longer.
  RgbdInput(const ::ros::NodeHandle& handle, const InputConfig& config, StageReport& report,
            Callbacks callbacks);
  ~RgbdInput();

  /// Puts one synchronised triple through conversion, checks and the pose queue.
  void addTriple(const sensor_msgs::ImageConstPtr& color, const sensor_msgs::ImageConstPtr& depth,
                 const sensor_msgs::CameraInfoConstPtr& info);
  /// Names silent topics and stamps that never match; to be called about once a second.
  void check();
  /// Frame id of the newest colour image's camera.
  std::string cameraFrame() const;

 private:
  using Image = sensor_msgs::Image;
  using Info = sensor_msgs::CameraInfo;
  using Exact =
      message_filters::Synchronizer<message_filters::sync_policies::ExactTime<Image, Image, Info>>;
  using Approximate = message_filters::Synchronizer<
      message_filters::sync_policies::ApproximateTime<Image, Image, Info>>;

  void resetSynchronizer();
  template <int kTopic, typename Message>
  void receive(const boost::shared_ptr<const Message>& message);
  void handleJumpBack();
  bool acceptStamp(Stamp stamp);
  std::shared_ptr<RgbdFrame> makeFrame(const sensor_msgs::ImageConstPtr& color,
                                       const sensor_msgs::ImageConstPtr& depth,
                                       const sensor_msgs::CameraInfoConstPtr& info);
  void checkSizes(const Image& color, const Image& depth, const Info& info) const;
  void checkMatches();

  const InputConfig config_;
  StageReport& report_;
  const Callbacks callbacks_;
  TopicWatch watch_;
  tf2_ros::Buffer tf_buffer_;
  tf2_ros::TransformListener tf_listener_;
  PoseWaiter pose_waiter_;
  StampOrder order_;
  StampOrder arrival_order_;  ///< of colour images before they are matched: sees jumps first
  mutable std::mutex mutex_;  ///< guards camera_frame_
  std::string camera_frame_;
  std::uint64_t num_matched_ = 0;
  std::uint64_t num_matched_at_check_ = 0;
  std::uint64_t num_color_at_check_ = 0;
  int checks_without_match_ = 0;
  std::unique_ptr<Exact> exact_;
  std::unique_ptr<Approximate> approximate_;
  ::ros::Subscriber color_;
  ::ros::Subscriber depth_;
  ::ros::Subscriber info_;
};

}  // namespace tsg::ros_interface
