// SPDX-License-Identifier: BSD-3-Clause
#include "correction_stage.h"

#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "task_scene_graph/ros/frame_names.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/loop_markers.h"
#include "task_scene_graph/trajectory/keyframes.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::nodelets {
namespace {

constexpr double kTfMemory_s = 12.0;
constexpr auto kHold = std::chrono::seconds(20);  ///< a save that ended without a word
constexpr auto kMaxWait = std::chrono::seconds(60);
constexpr double kOdometryAhead_s = 0.1;  ///< so long is the odometry's place in tf said to last
constexpr const char* kLoops = "loop closures";

std::string describePose(const nav_msgs::Path& path, std::size_t i) {
  return "pose " + std::to_string(i + 1) + " of " + std::to_string(path.poses.size());
}

std::string describe(const trajectory::OutsideCorrection& correction) {
  std::ostringstream text;
  text << correction.before.list().size() << " keyframes moved by up to " << correction.max_motion_m
       << " m and " << correction.max_turn_rad << " rad";
  return text.str();
}

/// Where the map has both ends.
std::vector<ros_interface::LoopMarkerLine> drawLines(const std::vector<LoopLine>& loops,
                                                     const Trajectory& own) {
  std::vector<ros_interface::LoopMarkerLine> lines;
  for (const LoopLine& loop : loops) {
    const auto a = own.poses().find(loop.a.ns);
    const auto b = own.poses().find(loop.b.ns);
    if (a == own.poses().end() || b == own.poses().end()) continue;
    lines.push_back(
        {a->second.translation(), b->second.translation(), loop.is_accepted, loop.residual_m});
  }
  return lines;
}

}  // namespace

CorrectionStage::CorrectionStage(ros::NodeHandle& handle, const Options& options,
                                 ros_interface::StageReport& report, Callbacks callbacks)
    : options_(options),
      report_(report),
      callbacks_(std::move(callbacks)),
      tf_history_(kTfMemory_s),
      worker_(1, [this](const nav_msgs::PathConstPtr& path) { process(path); }) {
  const CorrectionConfig& config = options_.config;
  if (!isOn()) return;
  if (config.odometry_frame == options_.world_frame) T_world_odometry_ = Pose::Identity();
  tf_feed_ = std::make_unique<ros_interface::TransformFeed>(
      tf_, tf_history_, [](const std::string&) {});  // the frames' own feed says it
  trajectory_publisher_ = {handle, "trajectory"};
  before_publisher_ = {handle, "trajectory_before"};
  if (config.close_loops) loop_publisher_ = {handle, "loop_closures"};
  if (config.path_topic.empty()) return;
  path_subscriber_ = handle.subscribe<nav_msgs::Path>(
      config.path_topic, 1, [this](const nav_msgs::PathConstPtr& path) { worker_.push(path); });
}

Pose CorrectionStage::toWorld(const RgbdFrame& frame) const {
  return trajectory::isIdentity(*T_world_odometry_) ? frame.T_world_camera
                                                    : *T_world_odometry_ * frame.T_world_camera;
}

void CorrectionStage::placeNew(const RgbdFramePtr& frame,
                               const std::function<void(const RgbdFramePtr&)>& hand_on) {
  if (!isOn()) return hand_on(frame);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (options_.config.odometry_frame != options_.world_frame) followTf(*frame);
  if (!T_world_odometry_) {
    return report_.countDropped(
        "no transform", "dropped a frame: tf does not link '" + options_.config.odometry_frame +
                            "' (corrections/odometry_frame) to '" + options_.world_frame + "'");
  }
  const auto placed = std::make_shared<RgbdFrame>(*frame);
  placed->T_world_camera = toWorld(*frame);
  own_.add(frame->stamp, placed->T_world_camera);
  if (tf_publisher_) sendOdometry(frame->stamp);
  hand_on(placed);
}

void CorrectionStage::placeAgain(const RgbdFramePtr& frame,
                                 const std::function<void(const RgbdFramePtr&)>& hand_on) {
  if (!isOn()) return hand_on(frame);
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto known = own_.poses().find(frame->stamp.ns);
  if (known == own_.poses().end()) return;  // of a map that is forgotten
  const auto placed = std::make_shared<RgbdFrame>(*frame);
  placed->T_world_camera = known->second;
  hand_on(placed);
}

std::optional<Pose> CorrectionStage::lookUpOdometry() const {
  try {
    return ros_interface::toPose(
        tf_.lookupTransform(options_.world_frame, options_.config.odometry_frame, ros::Time())
            .transform);
  } catch (const std::exception&) {
    return std::nullopt;  // not known, or not finite
  }
}

/// The first transform is where the odometry is; later ones say how the map's frame has moved.
void CorrectionStage::followTf(const RgbdFrame& frame) {
  if (T_world_odometry_ && !followsTf()) return;
  if (options_.config.close_loops) return startAtOdometry();
  const auto newest = lookUpOdometry();
  if (!newest) return;
  if (!T_world_odometry_) {
    T_world_odometry_ = newest;
    return;
  }
  const Pose motion = *newest * T_world_odometry_->inverse();
  const Eigen::Vector3d camera_m = toWorld(frame).translation();
  if (!isWorthIt((motion * camera_m - camera_m).norm(), trajectory::computeAngle(motion))) return;
  if (own_.isEmpty()) {
    T_world_odometry_ = newest;
    return;
  }
  if (isBusy()) return;  // the next frame comes to it
  try {
    correct(trajectory::makeOutsideCorrection(own_, motion, options_.world_frame,
                                              options_.config.outside));
    T_world_odometry_ = newest;
  } catch (const std::exception& e) {
    refuse("/tf, '" + options_.world_frame + "' -> '" + options_.config.odometry_frame + "'",
           e.what());
  }
}

/// Where tf knows the odometry's frame already, somebody else says where it is, and goes on to.
void CorrectionStage::startAtOdometry() {
  T_world_odometry_ = lookUpOdometry();
  if (!T_world_odometry_) {
    T_world_odometry_ = Pose::Identity();
    tf_publisher_ = ros::NodeHandle().advertise<tf2_msgs::TFMessage>("/tf", 100);
    return;
  }
  report_.warn("odometry in tf",
               "tf links '" + options_.world_frame + "' to '" + options_.config.odometry_frame +
                   "' already: what loop closures correct (corrections/close_loops) is not sent to "
                   "tf, so that two do not contradict each other");
}

void CorrectionStage::sendOdometry(Stamp stamp) const {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp =
      ros_interface::toRosTime(Stamp::fromSeconds(stamp.seconds() + kOdometryAhead_s));
  transform.header.frame_id = options_.world_frame;
  transform.child_frame_id = options_.config.odometry_frame;
  transform.transform = ros_interface::toTransform(*T_world_odometry_);
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  tf_publisher_.publish(message);
}

bool CorrectionStage::isWorthIt(double motion_m, double turn_rad) const {
  return motion_m >= options_.config.min_motion_m || turn_rad >= options_.config.min_turn_rad;
}

bool CorrectionStage::isBusy() const {
  return !under_way_.expired() || std::chrono::steady_clock::now() < held_until_;
}

void CorrectionStage::waitWhileBusy() const {
  const auto deadline = std::chrono::steady_clock::now() + kMaxWait;
  while (std::chrono::steady_clock::now() < deadline && !is_stopped_) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!isBusy()) return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  throw std::runtime_error("the correction before it is not done after a minute");
}

void CorrectionStage::process(const nav_msgs::PathConstPtr& path) {
  try {
    const Trajectory corrected = readPath(*path);
    waitWhileBusy();
    const std::lock_guard<std::mutex> lock(mutex_);
    if (has_jumped_back_) {
      throw std::invalid_argument(
          "stamps have jumped back since the map began, so it cannot be known which pass it is of");
    }
    correctTo(computeReported(), corrected);
  } catch (const std::exception& e) {
    const std::lock_guard<std::mutex> lock(mutex_);
    refuse(path_subscriber_.getTopic(), e.what());
  }
}

void CorrectionStage::follow(const LoopResult& loops) {
  try {
    waitWhileBusy();
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto& [first_ns, first_pose] = *loops.keyframes.poses().begin();
    const auto first = own_.poses().find(first_ns);
    if (first == own_.poses().end()) return;  // of a map that is forgotten
    const Pose T_world_start = first->second * first_pose.inverse();
    Trajectory corrected;
    for (const auto& [ns, pose] : loops.keyframes.poses())
      corrected.add({ns}, T_world_start * pose);
    correctTo(own_, corrected);
    loop_publisher_.publish(
        ros_interface::makeLoopMarkers(drawLines(loops.lines, own_), options_.world_frame));
  } catch (const std::exception& e) {
    const std::lock_guard<std::mutex> lock(mutex_);
    refuse(kLoops, e.what());
  }
}

/// @param reported  the way of the body whose corrected way is given, as the map has it
void CorrectionStage::correctTo(const Trajectory& reported, const Trajectory& corrected) {
  auto correction = trajectory::computeOutsideCorrection(
      own_, reported, corrected, options_.world_frame, options_.config.outside);
  if (isWorthIt(correction.max_motion_m, correction.max_turn_rad)) {
    correct(std::move(correction));
  } else {
    ++num_small_;
  }
}

Trajectory CorrectionStage::readPath(const nav_msgs::Path& path) const {
  const auto requireFrame = [&](const std::string& frame, const std::string& what) {
    if (ros_interface::stripLeadingSlash(frame) == options_.world_frame) return;
    throw std::invalid_argument(what + " is in frame '" + frame + "', expected world_frame, '" +
                                options_.world_frame + "'");
  };
  requireFrame(path.header.frame_id, "the path");
  Trajectory trajectory;
  for (std::size_t i = 0; i < path.poses.size(); ++i) {
    const geometry_msgs::PoseStamped& pose = path.poses[i];
    if (!pose.header.frame_id.empty()) requireFrame(pose.header.frame_id, describePose(path, i));
    const Stamp stamp = ros_interface::toStamp(pose.header.stamp);
    if (stamp == Stamp{} || (!trajectory.isEmpty() && stamp <= trajectory.last())) {
      throw std::invalid_argument(describePose(path, i) + " has stamp " +
                                  std::to_string(stamp.seconds()) +
                                  " s, expected one above 0 and after the pose before");
    }
    try {
      trajectory.add(stamp, ros_interface::toPose(pose.pose));
    } catch (const std::invalid_argument& e) {
      throw std::invalid_argument(describePose(path, i) + ": " + e.what());
    }
  }
  return trajectory;
}

/// The way of the path's body as the map has it.
Trajectory CorrectionStage::computeReported() const {
  const std::string body = options_.config.path_frame;
  if (body.empty() || own_.isEmpty()) return own_;
  const std::string camera = ros_interface::stripLeadingSlash(callbacks_.camera_frame());
  if (body == camera) return own_;
  Pose T_camera_body;
  try {
    T_camera_body = ros_interface::toPose(tf_.lookupTransform(camera, body, ros::Time()).transform);
  } catch (const std::exception& e) {
    throw std::invalid_argument("tf does not link corrections/path_frame, '" + body +
                                "', to the camera, '" + camera + "': " + e.what());
  }
  Trajectory reported;
  for (const auto& [ns, pose] : own_.poses()) reported.add({ns}, pose * T_camera_body);
  return reported;
}

/// All stages get it before any frame that follows.
void CorrectionStage::correct(trajectory::OutsideCorrection correction) {
  const auto step = std::make_shared<const MapCorrection>(
      MapCorrection{std::move(correction), options_.config.deformation});
  Trajectory moved = trajectory::applyCorrection(step->what.correction, step->what.before, own_);
  const Pose last_motion = step->motionAt(own_.last());
  publish(before_publisher_, own_);
  own_ = std::move(moved);
  T_world_odometry_ = last_motion * *T_world_odometry_;
  under_way_ = step;
  callbacks_.apply(step);
  ++num_applied_;
  report_.set("corrections: the last one", describe(step->what));
  publish(trajectory_publisher_, own_);
}

void CorrectionStage::refuse(const std::string& source, const std::string& reason) {
  if (is_stopped_) return;
  ++num_refused_;
  last_refusal_ = source + ": " + reason;
  report_.warn("correction refused",
               "correction refused, the map stays as it is: " + last_refusal_);
}

void CorrectionStage::stop() {
  is_stopped_ = true;
  path_subscriber_.shutdown();
  worker_.stop();
}

void CorrectionStage::hold() {
  const std::lock_guard<std::mutex> lock(mutex_);
  held_until_ = std::chrono::steady_clock::now() + kHold;
}

void CorrectionStage::release() {
  const std::lock_guard<std::mutex> lock(mutex_);
  held_until_ = {};
}

void CorrectionStage::startEpoch() {
  const std::lock_guard<std::mutex> lock(mutex_);
  has_jumped_back_ = true;
  own_ = {};
  tf_.clear();
}

void CorrectionStage::restart(const Trajectory& trajectory) {
  const std::lock_guard<std::mutex> lock(mutex_);
  has_jumped_back_ = false;
  own_ = trajectory;
  if (followsTf() && options_.config.odometry_frame != options_.world_frame) {
    T_world_odometry_ = lookUpOdometry();
  }
}

void CorrectionStage::check() {
  if (!isOn()) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  report_.set("corrections: applied", std::to_string(num_applied_));
  report_.set("corrections: refused",
              std::to_string(num_refused_) + (num_refused_ > 0 ? "; last: " + last_refusal_ : ""));
  report_.set("corrections: those that change too little", std::to_string(num_small_));
  report_.set("corrections: under way", under_way_.expired() ? "no" : "yes");
  if (trajectory_publisher_.numSubscribers() > 0) publish(trajectory_publisher_, own_);
}

void CorrectionStage::publish(const ros_interface::StatePublisher<nav_msgs::Path>& publisher,
                              const Trajectory& trajectory) const {
  nav_msgs::Path path;
  path.header.frame_id = options_.world_frame;
  if (!trajectory.isEmpty()) path.header.stamp = ros_interface::toRosTime(trajectory.last());
  const auto keyframes = trajectory::selectKeyframes(trajectory, options_.world_frame,
                                                     options_.config.outside.keyframes);
  for (const trajectory::Keyframe& keyframe : keyframes.list()) {
    geometry_msgs::PoseStamped pose;
    pose.header.frame_id = options_.world_frame;
    pose.header.stamp = ros_interface::toRosTime(keyframe.stamp);
    pose.pose = ros_interface::toPoseMessage(keyframe.T_world_camera);
    path.poses.push_back(pose);
  }
  publisher.publish(path);
}

}  // namespace tsg::nodelets
