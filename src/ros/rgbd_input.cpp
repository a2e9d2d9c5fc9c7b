// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/rgbd_input.h"

#include <sensor_msgs/CameraInfo.h>
#include <tf2/buffer_core.h>
#include <topic_tools/shape_shifter.h>

#include <boost/signals2/connection.hpp>
#include <chrono>
#include <mutex>
#include <utility>

#include "task_scene_graph/ros/frame_assembler.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/image_subscriber.h"
#include "task_scene_graph/ros/input_plausibility_report.h"
#include "task_scene_graph/ros/pose_source.h"
#include "task_scene_graph/ros/pose_waiter.h"
#include "task_scene_graph/ros/transform_feed.h"
#include "task_scene_graph/ros/transform_history.h"

namespace tsg::ros_interface {
namespace {

constexpr std::size_t kColor = 0;
constexpr std::size_t kDepth = 1;
// Seconds without any colour image after which no partner is waited for.
constexpr int kQuietChecks = 3;
// tf2's buffer forgets what is older than 10 s.
constexpr double kTfMemory_s = 12.0;
constexpr auto kFindingsPeriod = std::chrono::seconds(3);

PoseWaiter::Options toWaiterOptions(const InputConfig& config) {
  return {static_cast<std::size_t>(config.queue_size), config.tf_timeout_s};
}

}  // namespace

void checkInputFiles(const InputConfig& config) {
  const tf2::BufferCore tf;
  const PoseSource poses(config, tf);
  const FrameMaker maker(config, {});
}

class RgbdInput::Implementation {
 public:
  Implementation(const ::ros::NodeHandle& handle, const InputConfig& config, StageReport& report,
                 Callbacks callbacks,
                 const std::optional<plausibility::PlausibilityConfig>& plausibility);
  ~Implementation();

  TopicWatch& watch() { return watch_; }
  void check();
  void flush();
  std::string cameraFrame() const;

 private:
  FrameAssembler::Callbacks makeAssemblerCallbacks();
  InputTopics resolveTopics(const ::ros::NodeHandle& handle) const;
  void subscribe(const ::ros::NodeHandle& handle);
  void subscribeCameraInfo(::ros::NodeHandle handle);
  void subscribePoses(::ros::NodeHandle handle);
  void addPose(const topic_tools::ShapeShifter& message);
  void reportFindings();
  void followCompressed(ImageSubscriber& image, std::size_t number);
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

RgbdInput::Implementation::Implementation(
    const ::ros::NodeHandle& handle, const InputConfig& config, StageReport& report,
    Callbacks callbacks, const std::optional<plausibility::PlausibilityConfig>& plausibility)
    : config_(config),
      report_(report),
      callbacks_(std::move(callbacks)),
      plausibility_(plausibility ? std::make_unique<InputPlausibilityReport>(
                                       *plausibility, config.sync_tolerance_s)
                                 : nullptr),
      watch_(report, config.patience_s),
      tf_history_(kTfMemory_s),
      poses_(config, tf_buffer_, &tf_history_),
      pose_waiter_(
          poses_, toWaiterOptions(config), [] { return ::ros::Time::now().toSec(); },
          [this](RgbdFramePtr frame) {
            if (plausibility_) plausibility_->addFrame(*frame);
            callbacks_.on_frame(std::move(frame));
          },
          [this](const std::string& reason, const std::string& text) {
            report_.countDropped(reason, "dropped a frame: " + text);
          }),
      assembler_(std::make_unique<FrameAssembler>(config, resolveTopics(handle),
                                                  makeAssemblerCallbacks())) {
  tf_changed_ = tf_buffer_._addTransformsChangedListener([this] { pose_waiter_.notifyNews(); });
  tf_feed_ = std::make_unique<TransformFeed>(
      tf_buffer_, tf_history_,
      [this](const std::string& text) { report_.countDropped("bad transform", text); });
  subscribe(handle);
}

RgbdInput::Implementation::~Implementation() {
  color_->shutdown();
  depth_->shutdown();
  info_.shutdown();
  pose_.shutdown();
  tf_feed_.reset();  // joins the thread that notifies the waiter
}

InputTopics RgbdInput::Implementation::resolveTopics(const ::ros::NodeHandle& handle) const {
  return {handle.resolveName(config_.color_topic), handle.resolveName(config_.depth_topic),
          handle.resolveName(config_.camera_info_topic)};
}

FrameAssembler::Callbacks RgbdInput::Implementation::makeAssemblerCallbacks() {
  FrameAssembler::Callbacks callbacks;
  callbacks.on_frame = [this](AssembledFrame assembled) {
    camera_frame_ = assembled.camera_frame;
    assembled.frame->published_color = {};  // only a segmenter wants it, which has its own topic
    pose_waiter_.push(std::move(assembled.frame), assembled.camera_frame);
  };
  callbacks.on_drop = [this](const std::string& reason, const std::string& text,
                             std::uint64_t count) { report_.countDropped(reason, text, count); };
  callbacks.on_warning = [this](const std::string& key, const std::string& text) {
    report_.warn(key, text);
  };
  callbacks.on_jump_back = [this] { jumpBack(); };
  callbacks.on_image = [this](bool is_shared, const void* pixels) {
    report_.countImage(is_shared, pixels);
  };
  return callbacks;
}

void RgbdInput::Implementation::subscribe(const ::ros::NodeHandle& handle) {
  const auto queue_size = static_cast<std::uint32_t>(config_.queue_size);
  color_.emplace(handle, config_.color_topic, queue_size, [this](SourceImage image) {
    watch_.noteMessage(kColor);
    report_.countInput();
    const std::lock_guard<std::mutex> lock(mutex_);
    assembler_->addColor(std::move(image));
  });
  depth_.emplace(handle, config_.depth_topic, queue_size, [this](SourceImage image) {
    watch_.noteMessage(kDepth);
    const std::lock_guard<std::mutex> lock(mutex_);
    assembler_->addDepth(std::move(image));
  });
  watch_.add(color_->subscriber(), config_.color_topic, "sensor_msgs/Image");
  watch_.add(depth_->subscriber(), config_.depth_topic, "sensor_msgs/Image");
  if (config_.intrinsics.isEmpty()) subscribeCameraInfo(handle);
  if (poses_.usesTopic()) subscribePoses(handle);
}

void RgbdInput::Implementation::subscribeCameraInfo(::ros::NodeHandle handle) {
  const std::size_t number = watch_.nextNumber();
  info_ = handle.subscribe<sensor_msgs::CameraInfo>(
      config_.camera_info_topic, static_cast<std::uint32_t>(config_.queue_size),
      [this, number](const sensor_msgs::CameraInfoConstPtr& info) {
        watch_.noteMessage(number);
        const std::lock_guard<std::mutex> lock(mutex_);
        assembler_->addCameraInfo(info);
      });
  watch_.add(info_, config_.camera_info_topic, "sensor_msgs/CameraInfo");
}

void RgbdInput::Implementation::subscribePoses(::ros::NodeHandle handle) {
  const std::size_t number = watch_.nextNumber();
  pose_ = handle.subscribe<topic_tools::ShapeShifter>(
      config_.pose_topic, 1000, [this, number](const topic_tools::ShapeShifter::ConstPtr& message) {
        watch_.noteMessage(number);
        addPose(*message);
      });
  watch_.add(pose_, config_.pose_topic);
}

void RgbdInput::Implementation::addPose(const topic_tools::ShapeShifter& message) {
  try {
    poses_.add(message);
  } catch (const InputError& e) {
    report_.countDropped(e.reason(), std::string("ignored a pose: ") + e.what());
  } catch (const std::exception& e) {
    report_.countDropped("bad pose", "ignored a pose on " + config_.pose_topic + ": " + e.what());
  }
  pose_waiter_.notifyNews();
}

void RgbdInput::Implementation::jumpBack() {
  report_.countDropped("time jumped back", "", pose_waiter_.clear());
  tf_buffer_.clear();
  tf_history_.clear();
  poses_.clear();
  callbacks_.on_jump_back();
}

void RgbdInput::Implementation::flush() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    assembler_->flush();
  }
  reportFindings();
}

void RgbdInput::Implementation::reportFindings() {
  if (!plausibility_) return;
  FrameAssembler::Counters counters;
  FrameAssembler::FrameIds ids;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    counters = assembler_->counters();
    ids = assembler_->frameIds();
  }
  report_.setFindings(plausibility_->makeReport(counters, ids));
}

void RgbdInput::Implementation::check() {
  followCompressed(*color_, kColor);
  followCompressed(*depth_, kDepth);
  watch_.check();
  poses_.forgetOld();
  if (const std::string note = poses_.note(); !note.empty()) report_.warn("poses", note);
  const auto now = std::chrono::steady_clock::now();
  if (now - newest_findings_ > kFindingsPeriod) {
    newest_findings_ = now;
    reportFindings();
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto& counters = assembler_->counters();
  num_quiet_checks_ = counters.colors == num_colors_at_check_ ? num_quiet_checks_ + 1 : 0;
  num_colors_at_check_ = counters.colors;
  if (num_quiet_checks_ == kQuietChecks) assembler_->decide();
  report_.set("camera frame", camera_frame_);
  report_.set("waiting for a partner", std::to_string(assembler_->numWaiting()));
  report_.set("waiting for a pose", std::to_string(pose_waiter_.size()));
  report_.set("matched colour and depth", std::to_string(counters.matched));
  report_.set("depth images without a colour image", std::to_string(counters.unmatched_depths));
}

void RgbdInput::Implementation::followCompressed(ImageSubscriber& image, std::size_t number) {
  if (watch_.numMessages(number) > 0) return;
  const std::string change = image.switchToCompressed();
  if (change.empty()) return;
  report_.warn(change, change);
  watch_.replace(number, image.subscriber());
}

std::string RgbdInput::Implementation::cameraFrame() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return camera_frame_;
}

RgbdInput::RgbdInput(const ::ros::NodeHandle& handle, const InputConfig& config,
                     StageReport& report, Callbacks callbacks,
                     const std::optional<plausibility::PlausibilityConfig>& plausibility)
    : implementation_(std::make_unique<Implementation>(handle, config, report, std::move(callbacks),
                                                       plausibility)) {}
RgbdInput::~RgbdInput() = default;
void RgbdInput::check() { implementation_->check(); }
void RgbdInput::flush() { implementation_->flush(); }
TopicWatch& RgbdInput::watch() { return implementation_->watch(); }
std::string RgbdInput::cameraFrame() const { return implementation_->cameraFrame(); }

}  // namespace tsg::ros_interface
