// SPDX-License-Identifier: BSD-3-Clause
// Poses: transforms and odometry, and where the camera is by them.
#include <stdexcept>

#include "fuzzer.h"
#include "message_mutator.h"
#include "records.h"
#include "sample_messages.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/pose_source.h"
#include "task_scene_graph/ros/source_image.h"

namespace {

namespace fuzz = tsg::fuzz;
namespace ros_interface = tsg::ros_interface;

constexpr const char* kTopic = "/odometry";

std::string make(fuzz::Mutator& mutator) {
  const auto prepare = [&](auto message) {
    if (mutator.isOneIn(2)) fuzz::mutateMessage(mutator, message);
    return fuzz::toBytes(message);
  };
  fuzz::Records records;
  for (const double seconds : {9.9, 10.1}) {
    records.emplace_back('t', prepare(fuzz::makeTransform("world", "odom", seconds)));
    records.emplace_back('s', prepare(fuzz::makeTransform("base", "camera", seconds)));
    records.emplace_back('o', prepare(fuzz::makeOdometry(seconds)));
  }
  return fuzz::joinRecords(records);
}

/// As topic_tools::ShapeShifter gives it.
struct OdometryMessage {
  nav_msgs::OdometryPtr odometry;

  template <typename Message>
  boost::shared_ptr<Message> instantiate() const {
    if constexpr (std::is_same_v<Message, nav_msgs::Odometry>) {
      return odometry;
    } else {
      return nullptr;
    }
  }
  std::string getDataType() const { return "nav_msgs/Odometry"; }
};

void lookUp(const ros_interface::PoseSource& poses) {
  for (const double seconds : {0.0, 9.9, 10.0, 10.1, 4e9}) {
    const auto answer = poses.lookUp("camera", tsg::Stamp::fromSeconds(seconds));
    if (!answer.T_world_camera) {
      if (answer.why_not.empty()) throw std::logic_error("no pose, and not why");
    } else if (!answer.T_world_camera->matrix().allFinite()) {
      throw std::logic_error("a pose that is not finite");
    }
  }
}

/// A bad message is refused, the others are read.
void readInput(const std::string& input) {
  tf2::BufferCore tf(ros::Duration(1000.0));
  ros_interface::InputConfig config;
  config.pose_topic = kTopic;
  ros_interface::PoseSource poses(config, tf);
  config.pose_topic.clear();
  const ros_interface::PoseSource tf_poses(config, tf);
  std::exception_ptr refusal;
  for (const auto& [type, bytes] : fuzz::splitRecords(input)) {
    try {
      if (type == 'o') {
        poses.add(OdometryMessage{fuzz::fromBytes<nav_msgs::Odometry>(bytes)});
        continue;
      }
      const auto transform = fuzz::fromBytes<geometry_msgs::TransformStamped>(bytes);
      ros_interface::checkStamp(transform->header.stamp, kTopic);
      tf.setTransform(*transform, "fuzz", type == 's');
    } catch (const std::exception&) {
      refusal = std::current_exception();
    }
  }
  lookUp(poses);
  lookUp(tf_poses);
  if (refusal) std::rethrow_exception(refusal);
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv, {"poses", kTopic, make, readInput});
}
