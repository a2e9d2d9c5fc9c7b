// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/rgbd_input.h"

#include <sstream>
#include <utility>

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

constexpr auto kColorTopic = "camera/color/image_raw";
constexpr auto kDepthTopic = "camera/aligned_depth_to_color/image_raw";
constexpr auto kInfoTopic = "camera/color/camera_info";
constexpr std::size_t kColor = 0;
constexpr std::size_t kDepth = 1;
constexpr std::size_t kInfo = 2;

PoseWaiter::Options toWaiterOptions(const InputConfig& config) {
  return {config.world_frame, static_cast<std::size_t>(config.queue_size), config.tf_timeout_s};
}

const char* nameOf(PoseWaiter::Reason reason) {
  return reason == PoseWaiter::Reason::kNoTransform ? "no transform" : "pose queue full";
}

std::string formatSize(std::uint32_t width, std::uint32_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace

RgbdInput::RgbdInput(const ::ros::NodeHandle& handle, const InputConfig& config,
                     StageReport& report, Callbacks callbacks)
    : config_(config),
      report_(report),
      callbacks_(std::move(callbacks)),
      watch_(report, config.patience_s),
      tf_listener_(tf_buffer_),
      pose_waiter_(
          tf_buffer_, toWaiterOptions(config), [] { return ::ros::Time::now().toSec(); },
          [this](RgbdFramePtr frame) { callbacks_.on_frame(std::move(frame)); },
          [this](PoseWaiter::Reason reason, const std::string& text) {
            report_.countDropped(nameOf(reason), "dropped a frame: " + text);
          }) {
  resetSynchronizer();
  ::ros::NodeHandle subscriber_handle(handle);
  const auto queue_size = static_cast<std::uint32_t>(config_.queue_size);
  color_ = subscriber_handle.subscribe<Image>(kColorTopic, queue_size,
                                              &RgbdInput::receive<kColor, Image>, this);
  depth_ = subscriber_handle.subscribe<Image>(kDepthTopic, queue_size,
                                              &RgbdInput::receive<kDepth, Image>, this);
  info_ = subscriber_handle.subscribe<Info>(kInfoTopic, queue_size,
                                            &RgbdInput::receive<kInfo, Info>, this);
  watch_.add(color_, kColorTopic);
  watch_.add(depth_, kDepthTopic);
  watch_.add(info_, kInfoTopic);
}

RgbdInput::~RgbdInput() {
  color_.shutdown();
  depth_.shutdown();
  info_.shutdown();
}

void RgbdInput::resetSynchronizer() {
  const auto queue_size = static_cast<std::uint32_t>(config_.queue_size);
  exact_.reset();
  approximate_.reset();
  if (config_.sync_tolerance_s <= 0.0) {
    exact_ = std::make_unique<Exact>(
        message_filters::sync_policies::ExactTime<Image, Image, Info>(queue_size));
    exact_->registerCallback(&RgbdInput::addTriple, this);
    return;
  }
  approximate_ = std::make_unique<Approximate>(
      message_filters::sync_policies::ApproximateTime<Image, Image, Info>(queue_size));
  approximate_->setMaxIntervalDuration(::ros::Duration(config_.sync_tolerance_s));
  approximate_->registerCallback(&RgbdInput::addTriple, this);
}

template <int kTopic, typename Message>
void RgbdInput::receive(const boost::shared_ptr<const Message>& message) {
  watch_.noteMessage(kTopic);
  if constexpr (kTopic == kColor) {
    report_.countInput();
    const auto kind = arrival_order_.update(toStamp(message->header.stamp));
    if (kind == StampOrder::Kind::kJumpBack) handleJumpBack();
  }
  const ::ros::MessageEvent<const Message> event(message);
  if (exact_ != nullptr) {
    exact_->add<kTopic>(event);
  } else {
    approximate_->add<kTopic>(event);
  }
}

void RgbdInput::handleJumpBack() {
  report_.warn("time jumped back",
               "stamps jumped back by more than a second (a bag in a loop?): tf is cleared, frames "
               "start anew");
  resetSynchronizer();
  report_.countDropped("time jumped back", "", pose_waiter_.clear());
  tf_buffer_.clear();
  order_ = StampOrder();
  callbacks_.on_jump_back();
}

void RgbdInput::addTriple(const sensor_msgs::ImageConstPtr& color,
                          const sensor_msgs::ImageConstPtr& depth,
                          const sensor_msgs::CameraInfoConstPtr& info) {
  ++num_matched_;
  if (!acceptStamp(toStamp(color->header.stamp))) return;
  try {
    const std::string camera_frame =
        config_.camera_frame.empty() ? color->header.frame_id : config_.camera_frame;
    pose_waiter_.push(makeFrame(color, depth, info), camera_frame);
    const std::lock_guard<std::mutex> lock(mutex_);
    camera_frame_ = camera_frame;
  } catch (const InputError& e) {
    report_.countDropped(e.reason(), std::string("dropped a frame: ") + e.what());
  } catch (const std::exception& e) {
    report_.countDropped("unusable images", std::string("dropped a frame: ") + e.what());
  }
}

bool RgbdInput::acceptStamp(Stamp stamp) {
  switch (order_.update(stamp)) {
    case StampOrder::Kind::kDuplicate:
      report_.countDropped("repeated stamp",
                           "dropped a frame: its stamp is that of the one before");
      return false;
    case StampOrder::Kind::kLate:
      report_.countDropped("late", "dropped a frame: it is older than the one before");
      return false;
    default:
      return true;
  }
}

std::shared_ptr<RgbdFrame> RgbdInput::makeFrame(const sensor_msgs::ImageConstPtr& color,
                                                const sensor_msgs::ImageConstPtr& depth,
                                                const sensor_msgs::CameraInfoConstPtr& info) {
  checkSizes(*color, *depth, *info);
  auto frame = std::make_shared<RgbdFrame>();
  frame->stamp = toStamp(color->header.stamp);
  frame->camera = toCameraModel(*info, info_.getTopic());
  frame->color = toColorImage(color, color_.getTopic());
  frame->depth = toDepthImage(depth, depth_.getTopic());
  report_.countImage(isShared(frame->color.image, *color), frame->color.image.data);
  report_.countImage(isShared(frame->depth.image, *depth), frame->depth.image.data);
  if (hasDistortion(*info)) {
    report_.warn("distortion", "camera_info on " + info_.getTopic() +
                                   " reports a lens distortion, but images are taken as "
                                   "rectified; remap to the rectified topics (image_proc)");
  }
  return frame;
}

void RgbdInput::checkSizes(const Image& color, const Image& depth, const Info& info) const {
  if (color.width != depth.width || color.height != depth.height) {
    throw InputError("depth on " + depth_.getTopic() + " is " +
                         formatSize(depth.width, depth.height) + ", colour on " +
                         color_.getTopic() + " is " + formatSize(color.width, color.height) +
                         "; expected depth registered to colour, of the same size",
                     "sizes differ");
  }
  if (color.width != info.width || color.height != info.height) {
    throw InputError("camera_info on " + info_.getTopic() + " is for " +
                         formatSize(info.width, info.height) + ", images on " + color_.getTopic() +
                         " are " + formatSize(color.width, color.height),
                     "sizes differ");
  }
}

void RgbdInput::check() {
  watch_.check();
  checkMatches();
  report_.set("camera frame", cameraFrame());
  report_.set("waiting for a pose", std::to_string(pose_waiter_.size()));
  report_.set("matched colour/depth/camera_info", std::to_string(num_matched_));
}

void RgbdInput::checkMatches() {
  const std::uint64_t num_color = watch_.numMessages(kColor);
  const bool has_all = watch_.numMessages(kDepth) > 0 && watch_.numMessages(kInfo) > 0;
  const bool is_stuck =
      has_all && num_color > num_color_at_check_ && num_matched_ == num_matched_at_check_;
  checks_without_match_ = is_stuck ? checks_without_match_ + 1 : 0;
  num_color_at_check_ = num_color;
  num_matched_at_check_ = num_matched_;
  if (checks_without_match_ < 3) return;
  std::ostringstream text;
  text << "messages arrive on " << color_.getTopic() << ", " << depth_.getTopic() << " and "
       << info_.getTopic() << ", but no three stamps lie within " << config_.sync_tolerance_s
       << " s; raise input/sync_tolerance_s";
  report_.warn("no match", text.str());
}

std::string RgbdInput::cameraFrame() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return camera_frame_;
}

}  // namespace tsg::ros_interface
