// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/pose_source.h"

#include <tf2/exceptions.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "task_scene_graph/ros/frame_names.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/source_image.h"

namespace tsg::ros_interface {
namespace {

// A hole is so many times longer than what is usual for its link.
constexpr double kHoleInSpacings = 3.0;
// Between poses no farther apart any way of interpolating does.
constexpr double kStandstill_m = 0.02;
constexpr double kStandstill_rad = 0.02;
constexpr std::size_t kMaxFramesNamed = 12;
// As in messages: what is farther is no place on earth.
constexpr double kLargest_m = 1e9;
// A live topic's older poses are of no use: frames do not wait longer.
constexpr std::int64_t kMemory_ns = 60'000'000'000;

std::string formatSeconds(double seconds) {
  std::ostringstream text;
  text.precision(3);
  text << std::fixed << seconds;
  return text.str();
}

std::string listFrames(const tf2::BufferCore& tf) {
  std::vector<std::string> frames;
  tf._getFrameStrings(frames);
  if (frames.empty()) return "it knows none: nothing has come on /tf or /tf_static";
  std::sort(frames.begin(), frames.end());
  std::string text = "it knows: ";
  for (std::size_t i = 0; i < std::min(frames.size(), kMaxFramesNamed); ++i) {
    text += (i == 0 ? "" : ", ") + frames[i];
  }
  return text + (frames.size() > kMaxFramesNamed ? ", ..." : "");
}

std::string findRoot(const tf2::BufferCore& tf, std::string frame) {
  std::string parent;
  for (int depth = 0; depth < 100 && tf._getParent(frame, ::ros::Time(0), parent); ++depth) {
    frame = parent;
  }
  return frame;
}

bool isConnected(const tf2::BufferCore& tf, const std::string& target, const std::string& source) {
  return tf._frameExists(target) && tf._frameExists(source) &&
         findRoot(tf, target) == findRoot(tf, source);
}

/// In a user's words, what tf lacks.
std::string explainMissingTransform(const tf2::BufferCore& tf, const std::string& target,
                                    const std::string& source) {
  if (!tf._frameExists(target)) {
    return "tf knows no frame '" + target + "' (" + listFrames(tf) +
           "); set input/world_frame (world_frame:=, --world-frame) where that is the map's frame";
  }
  if (!tf._frameExists(source)) {
    return "tf knows no frame '" + source + "' (" + listFrames(tf) +
           "); its link is usually on /tf_static (of a split recording: give its first part too), "
           "or set input/camera_frame (camera_frame:=, --camera-frame)";
  }
  const std::string target_root = findRoot(tf, target);
  const std::string source_root = findRoot(tf, source);
  if (target_root != source_root) {
    return "the link between '" + target_root + "' and '" + source_root +
           "' is missing in tf (usually on /tf_static, or from an odometry that does not run)";
  }
  return "tf links them, but not at this stamp";
}

/// Stamp of the newest moment at which tf knows the transform.
std::optional<Stamp> findNewest(const tf2::BufferCore& tf, const std::string& target,
                                const std::string& source) {
  try {
    return toStamp(tf.lookupTransform(target, source, ::ros::Time(0)).header.stamp);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

PoseSource::Answer explainHole(const TransformHistory::Gap& hole, Stamp stamp, double limit_s) {
  PoseSource::Answer answer;
  answer.reason = "hole in tf";
  answer.is_final = true;
  answer.why_not = "stamp " + formatSeconds(stamp.seconds()) + " s lies in a hole of tf: '" +
                   hole.child + "' was not published from " + formatSeconds(hole.before.seconds()) +
                   " to " + formatSeconds(hole.after.seconds()) + " s (" +
                   formatSeconds(hole.length_s) + " s; usually about every " +
                   formatSeconds(hole.usual_s) +
                   " s), and the camera moved meanwhile; input/max_tf_gap_s, " +
                   formatSeconds(limit_s) + " s, is the longest over which it is interpolated";
  return answer;
}

/// Links that are finite each can be too large together.
bool isUsable(const Pose& T_world_camera) {
  return T_world_camera.matrix().allFinite() &&
         T_world_camera.translation().cwiseAbs().maxCoeff() <= kLargest_m;
}

PoseSource::Answer explainUnusable(const Pose& T_world_camera, Stamp stamp,
                                   const std::string& source) {
  std::ostringstream text;
  text << "the camera's position " << source << " at stamp " << formatSeconds(stamp.seconds())
       << " s is (" << T_world_camera.translation().transpose()
       << ") m, expected coordinates within " << kLargest_m << " m";
  PoseSource::Answer answer;
  answer.reason = "bad pose";
  answer.is_final = true;
  answer.why_not = text.str();
  return answer;
}

/// Coordinates in the optical frame -> coordinates in a frame with the given axes.
Pose toOptical(CameraAxes axes) {
  Pose T = Pose::Identity();
  if (axes == CameraAxes::kOpenGl) T.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  if (axes == CameraAxes::kBody) T.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T;
}

}  // namespace

PoseSource::PoseSource(const InputConfig& config, const tf2::BufferCore& tf,
                       const TransformHistory* history)
    : config_(config), tf_(tf), history_(history) {
  checkInput(config_);
  if (config_.trajectory.empty()) return;
  trajectory_ = loadTumTrajectory(config_.trajectory.string());
  parent_frame_ = config_.world_frame;
}

void PoseSource::addPose(const std_msgs::Header& header, const std::string& child_frame,
                         const geometry_msgs::Pose& pose) {
  checkStamp(header.stamp, config_.pose_topic);
  Pose T_parent_child;
  try {
    T_parent_child = toPose(pose);
  } catch (const std::invalid_argument& e) {
    throw InputError("pose on " + config_.pose_topic + ": " + e.what(), "bad pose");
  }
  const Stamp stamp = toStamp(header.stamp);
  const std::lock_guard<std::mutex> lock(mutex_);
  trajectory_.add(stamp, T_parent_child);
  parent_frame_ = stripLeadingSlash(header.frame_id);
  child_frame_ = stripLeadingSlash(child_frame);
}

void PoseSource::addTransform(const geometry_msgs::TransformStamped& transform) {
  geometry_msgs::Pose pose;
  pose.position.x = transform.transform.translation.x;
  pose.position.y = transform.transform.translation.y;
  pose.position.z = transform.transform.translation.z;
  pose.orientation = transform.transform.rotation;
  addPose(transform.header, transform.child_frame_id, pose);
}

void PoseSource::failType(const std::string& type) const {
  throw InputError("messages on " + config_.pose_topic + " are of type " + type +
                       ", expected nav_msgs/Odometry, geometry_msgs/PoseStamped, "
                       "PoseWithCovarianceStamped or TransformStamped",
                   "bad pose");
}

PoseSource::Answer PoseSource::lookUp(const std::string& camera_frame, Stamp stamp) const {
  const std::string frame = stripLeadingSlash(camera_frame);
  Answer answer;
  if (frame.empty() && usesTf()) {
    answer.why_not =
        "the images' frame_id is empty; set input/camera_frame (camera_frame:=, "
        "--camera-frame) to the camera's optical frame";
    answer.is_final = true;
    return answer;
  }
  answer = usesTf() ? lookUpTf(config_.world_frame, frame, stamp) : lookUpTrajectory(frame, stamp);
  if (answer.T_world_camera && !isUsable(*answer.T_world_camera)) {
    answer = explainUnusable(*answer.T_world_camera, stamp, usesTf() ? "by /tf" : sourceName());
  } else if (answer.T_world_camera) {
    answer.T_world_camera = *answer.T_world_camera * toOptical(config_.camera_axes);
  } else if (answer.reason.empty()) {
    answer.reason = usesTf() ? "no transform" : "no pose";
  }
  return answer;
}

PoseSource::Answer PoseSource::lookUpTf(const std::string& target, const std::string& source,
                                        Stamp stamp) const {
  Answer answer;
  try {
    answer.T_world_camera =
        ros_interface::toPose(tf_.lookupTransform(target, source, toRosTime(stamp)).transform);
    const auto hole = findHole(target, source, stamp);
    return hole ? explainHole(*hole, stamp, config_.max_tf_gap_s) : answer;
  } catch (const std::invalid_argument& e) {  // links that are finite each, not all together
    answer.reason = "bad pose";
    answer.is_final = true;
    answer.why_not = "transform on /tf from '" + source + "' to '" + target + "' at stamp " +
                     formatSeconds(stamp.seconds()) + " s: " + e.what();
    return answer;
  } catch (const std::exception&) {
    answer.why_not = "no transform from '" + source + "' to '" + target + "' at stamp " +
                     formatSeconds(stamp.seconds()) + " s: ";
  }
  const auto newest = findNewest(tf_, target, source);
  answer.why_not += explainMissingTransform(tf_, target, source);
  if (newest) {
    answer.is_final = stamp < *newest;
    answer.why_not += ": its newest is of " + formatSeconds(newest->seconds()) + " s" +
                      (answer.is_final ? ", so it begins later, or was lost for a while" : "");
  }
  return answer;
}

std::optional<TransformHistory::Gap> PoseSource::findHole(const std::string& target,
                                                          const std::string& source,
                                                          Stamp stamp) const {
  if (history_ == nullptr) return std::nullopt;
  const auto gap = history_->findGap(tf_, target, source, stamp);
  if (!gap || gap->length_s <= config_.max_tf_gap_s || !hasMoved(target, source, *gap)) {
    return std::nullopt;
  }
  if (gap->length_s > kHoleInSpacings * gap->usual_s) return gap;
  const std::lock_guard<std::mutex> lock(mutex_);
  slow_link_ = "tf has '" + gap->child + "' only about every " + formatSeconds(gap->usual_s) +
               " s: the camera's poses between are interpolated; publish it more often where the "
               "map is blurred";
  return std::nullopt;
}

bool PoseSource::hasMoved(const std::string& target, const std::string& source,
                          const TransformHistory::Gap& gap) const {
  try {
    const auto lookUpAt = [&](Stamp stamp) {
      return ros_interface::toPose(tf_.lookupTransform(target, source, toRosTime(stamp)).transform);
    };
    const Pose T_before_after = lookUpAt(gap.before).inverse() * lookUpAt(gap.after);
    return T_before_after.translation().norm() > kStandstill_m ||
           Eigen::AngleAxisd(T_before_after.linear()).angle() > kStandstill_rad;
  } catch (const std::exception&) {
    return true;  // another link is not known there
  }
}

PoseSource::Answer PoseSource::lookUpTrajectory(const std::string& camera_frame,
                                                Stamp stamp) const {
  std::optional<Pose> T_parent_child;
  std::string parent;
  std::string child;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    T_parent_child = trajectory_.interpolate(stamp, config_.max_pose_gap_s);
    parent = parent_frame_;
    child = config_.pose_frame.empty() ? child_frame_ : config_.pose_frame;
  }
  if (!T_parent_child) return explainMissingPose(stamp);
  if (config_.pose_direction == PoseDirection::kWorldToCamera) {
    T_parent_child = T_parent_child->inverse();
  }
  Answer answer;
  answer.T_world_camera = *T_parent_child;
  if (!child.empty() && child != camera_frame) {
    Answer link = lookUpTf(child, camera_frame, stamp);
    if (!link.T_world_camera) {
      link.why_not = "poses " + sourceName() + " are of frame '" + child + "', but " +
                     link.why_not + "; if they are the camera's own, set input/pose_frame " +
                     "(--pose-frame) to '" + camera_frame + "'";
      return link;
    }
    answer.T_world_camera = *answer.T_world_camera * *link.T_world_camera;
  }
  if (parent != config_.world_frame && isConnected(tf_, config_.world_frame, parent)) {
    const Answer link = lookUpTf(config_.world_frame, parent, stamp);
    if (!link.T_world_camera) return link;
    answer.T_world_camera = *link.T_world_camera * *answer.T_world_camera;
  }
  return answer;
}

PoseSource::Answer PoseSource::explainMissingPose(Stamp stamp) const {
  Answer answer;
  answer.why_not =
      "no pose " + sourceName() + " at stamp " + formatSeconds(stamp.seconds()) + " s: ";
  const std::lock_guard<std::mutex> lock(mutex_);
  if (trajectory_.isEmpty()) {
    answer.why_not += "none has come";
    return answer;
  }
  const double gap_s = trajectory_.gapAt(stamp);
  answer.is_final = stamp < trajectory_.last() || !config_.trajectory.empty();
  if (gap_s > 0.0) {
    answer.why_not += "the poses around it are " + formatSeconds(gap_s) +
                      " s apart, more than input/max_pose_gap_s, " +
                      formatSeconds(config_.max_pose_gap_s) + " s";
  } else {
    answer.why_not += "its poses go from " + formatSeconds(trajectory_.first().seconds()) + " to " +
                      formatSeconds(trajectory_.last().seconds()) + " s";
  }
  return answer;
}

std::string PoseSource::sourceName() const {
  return config_.trajectory.empty() ? "on " + config_.pose_topic
                                    : "in trajectory '" + config_.trajectory.string() + "'";
}

std::string PoseSource::note() const {
  std::string parent;
  std::string slow_link;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    parent = parent_frame_;
    slow_link = slow_link_;
  }
  if (!usesTopic()) return slow_link;
  const bool is_taken_as_world = !parent.empty() && parent != config_.world_frame &&
                                 !isConnected(tf_, config_.world_frame, parent);
  if (!is_taken_as_world) return slow_link;
  return "poses on " + config_.pose_topic + " are in frame '" + parent +
         "', which tf does not link to world_frame '" + config_.world_frame +
         "': they are taken as poses in the latter; set input/world_frame to '" + parent +
         "' if that is meant";
}

void PoseSource::forgetOld() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!usesTopic() || trajectory_.isEmpty()) return;
  trajectory_.forgetBefore({trajectory_.last().ns - kMemory_ns});
}

void PoseSource::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (usesTopic()) trajectory_ = Trajectory();
}

}  // namespace tsg::ros_interface
