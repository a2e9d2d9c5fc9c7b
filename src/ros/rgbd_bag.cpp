// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/rgbd_bag.h"

#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <tf2/buffer_core.h>
#include <tf2/exceptions.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <stdexcept>
#include <vector>

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"

namespace tsg::ros_interface {
namespace {

// A recorded segmentation may follow its image by as much as inference took.
constexpr double kSegmentationWait_s = 10.0;

struct PendingFrame {
  sensor_msgs::ImageConstPtr color;
  sensor_msgs::ImageConstPtr depth;
  SegmentationPtr segmentation;
};

double computeDistance(const sensor_msgs::Image& a, const sensor_msgs::Image& b) {
  return std::abs((a.header.stamp - b.header.stamp).toSec());
}

}  // namespace

class RgbdBag::Implementation {
 public:
  Implementation(const std::string& path, const BagOptions& options) : options_(options) {
    try {
      bag_.open(path, rosbag::bagmode::Read);
    } catch (const rosbag::BagException& e) {
      throw std::runtime_error("cannot read bag '" + path + "': " + e.what());
    }
    num_color_ = requireTopic(path, options_.topics.color);
    requireTopic(path, options_.topics.depth);
    requireTopic(path, options_.topics.camera_info);
    has_segmentation_ =
        options_.use_recorded_segmentation && countMessages(options_.topics.segmentation) > 0;
    readTransforms();
  }

  std::size_t numColorImages() const { return num_color_; }
  bool hasRecordedSegmentation() const { return has_segmentation_; }
  const std::map<std::string, Drops>& drops() const { return drops_; }

  void forEachFrame(const OnFrame& on_frame, const std::function<void(std::size_t)>& on_progress) {
    drops_.clear();
    pending_.clear();
    depths_.clear();
    info_.reset();
    newest_ = ros::Time();
    std::vector<std::string> topics{options_.topics.color, options_.topics.depth,
                                    options_.topics.camera_info};
    if (has_segmentation_) topics.push_back(options_.topics.segmentation);
    rosbag::View view(bag_, rosbag::TopicQuery(topics));
    std::size_t num_read = 0;
    for (const rosbag::MessageInstance& message : view) {
      take(message);
      release(false, on_frame);
      if (message.getTopic() == options_.topics.color) on_progress(++num_read);
    }
    release(true, on_frame);
  }

 private:
  std::size_t countMessages(const std::string& topic) {
    return rosbag::View(bag_, rosbag::TopicQuery(topic)).size();
  }

  std::size_t requireTopic(const std::string& path, const std::string& topic) {
    const std::size_t count = countMessages(topic);
    if (count > 0) return count;
    std::string present;
    for (const auto* connection : rosbag::View(bag_).getConnections()) {
      present += "\n  " + connection->topic + " (" + connection->datatype + ")";
    }
    throw std::runtime_error("bag '" + path + "' has no messages on topic '" + topic +
                             "'; its topics are:" + present);
  }

  void readTransforms() {
    rosbag::View all(bag_);
    const ros::Duration length = all.getEndTime() - all.getBeginTime();
    transforms_ = std::make_unique<tf2::BufferCore>(length + ros::Duration(60.0));
    for (const auto& message :
         rosbag::View(bag_, rosbag::TopicQuery(std::vector<std::string>{"/tf", "/tf_static"}))) {
      const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
      if (!transforms) continue;
      const bool is_static = message.getTopic() == "/tf_static";
      for (const auto& transform : transforms->transforms) {
        transforms_->setTransform(transform, "bag", is_static);
      }
    }
  }

  void take(const rosbag::MessageInstance& message) {
    const std::string& topic = message.getTopic();
    if (topic == options_.topics.color) {
      if (auto image = message.instantiate<sensor_msgs::Image>()) addColor(image);
    } else if (topic == options_.topics.depth) {
      if (auto image = message.instantiate<sensor_msgs::Image>()) addDepth(image);
    } else if (topic == options_.topics.camera_info) {
      if (auto info = message.instantiate<sensor_msgs::CameraInfo>()) info_ = info;
    } else if (auto segmentation = message.instantiate<msg::Segmentation>()) {
      addSegmentation(segmentation);
    }
  }

  void addColor(const sensor_msgs::ImageConstPtr& color) {
    newest_ = std::max(newest_, color->header.stamp);
    pending_.push_back({color, nullptr, nullptr});
    for (const auto& depth : depths_) pair(pending_.back(), depth);
  }

  void addDepth(const sensor_msgs::ImageConstPtr& depth) {
    depths_.push_back(depth);
    if (depths_.size() > 16) depths_.pop_front();
    for (auto& frame : pending_) pair(frame, depth);
  }

  /// The depth image nearest in time wins.
  void pair(PendingFrame& frame, const sensor_msgs::ImageConstPtr& depth) const {
    const double distance = computeDistance(*frame.color, *depth);
    if (distance > options_.sync_tolerance_s) return;
    if (!frame.depth || distance < computeDistance(*frame.color, *frame.depth)) frame.depth = depth;
  }

  void addSegmentation(const msg::SegmentationConstPtr& message) {
    for (auto& frame : pending_) {
      if (frame.color->header.stamp != message->header.stamp) continue;
      try {
        frame.segmentation = fromMessage(message, options_.topics.segmentation);
      } catch (const std::exception& e) {
        drop("segmentation", e.what());
      }
      return;
    }
    drop("segmentation",
         "no colour image has its stamp " + std::to_string(message->header.stamp.toSec()) + " s");
  }

  /// Hands out the frames at the front for which nothing more can come.
  void release(bool is_end, const OnFrame& on_frame) {
    while (!pending_.empty() && (is_end || isComplete(pending_.front()))) {
      const PendingFrame frame = pending_.front();
      pending_.pop_front();
      emit(frame, on_frame);
    }
  }

  bool isComplete(const PendingFrame& frame) const {
    const double age_s = (newest_ - frame.color->header.stamp).toSec();
    const bool has_depth = frame.depth && frame.depth->header.stamp == frame.color->header.stamp;
    if (!has_depth && age_s < 0.5 + options_.sync_tolerance_s) return false;
    if (!info_ && age_s < kSegmentationWait_s) return false;
    return !has_segmentation_ || frame.segmentation || age_s > kSegmentationWait_s;
  }

  void emit(const PendingFrame& pending, const OnFrame& on_frame) {
    RgbdFramePtr frame;
    try {
      frame = makeFrame(pending);
    } catch (const std::exception& e) {
      drop("bad input", e.what());
    }
    if (frame) on_frame(frame, pending.segmentation);
  }

  RgbdFramePtr makeFrame(const PendingFrame& pending) {
    const std::string at =
        " for the colour image at " + std::to_string(pending.color->header.stamp.toSec()) + " s";
    if (!pending.depth) return drop("no depth", "no depth image on " + options_.topics.depth + at);
    if (!info_) return drop("no camera info", "nothing on " + options_.topics.camera_info + at);
    auto frame = std::make_shared<RgbdFrame>();
    frame->stamp = toStamp(pending.color->header.stamp);
    frame->camera = toCameraModel(*info_, options_.topics.camera_info);
    frame->color = toColorImage(pending.color, options_.topics.color);
    frame->depth = toDepthImage(pending.depth, options_.topics.depth);
    try {
      frame->T_world_camera =
          toPose(transforms_
                     ->lookupTransform(options_.world_frame, pending.color->header.frame_id,
                                       pending.color->header.stamp)
                     .transform);
    } catch (const tf2::TransformException& e) {
      return drop("no pose", e.what() + at);
    }
    frame->validate();
    return frame;
  }

  RgbdFramePtr drop(const std::string& reason, const std::string& example) {
    auto& drops = drops_[reason];
    if (drops.count++ == 0) drops.example = example;
    return nullptr;
  }

  BagOptions options_;
  rosbag::Bag bag_;
  std::size_t num_color_ = 0;
  bool has_segmentation_ = false;
  std::unique_ptr<tf2::BufferCore> transforms_;
  std::deque<PendingFrame> pending_;
  std::deque<sensor_msgs::ImageConstPtr> depths_;
  sensor_msgs::CameraInfoConstPtr info_;
  ros::Time newest_;  ///< of all colour images read
  std::map<std::string, Drops> drops_;
};

RgbdBag::RgbdBag(const std::string& path, const BagOptions& options)
    : implementation_(std::make_unique<Implementation>(path, options)) {}
RgbdBag::~RgbdBag() = default;
std::size_t RgbdBag::numColorImages() const { return implementation_->numColorImages(); }
bool RgbdBag::hasRecordedSegmentation() const { return implementation_->hasRecordedSegmentation(); }
void RgbdBag::forEachFrame(const OnFrame& on_frame,
                           const std::function<void(std::size_t)>& on_progress) {
  implementation_->forEachFrame(on_frame, on_progress);
}
const std::map<std::string, RgbdBag::Drops>& RgbdBag::drops() const {
  return implementation_->drops();
}

}  // namespace tsg::ros_interface
