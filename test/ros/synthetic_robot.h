// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <gtest/gtest.h>
#include <nodelet/loader.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Log.h>
#include <sensor_msgs/CameraInfo.h>
#include <tf2_ros/transform_broadcaster.h>

#include <boost/make_shared.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "synthetic_scene.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"

/// A robot in a room with a red and a blue box, all in closed form, for rostests.
namespace tsg::test {

constexpr int kEmbeddingSize = 4;  ///< e0: red box, e1: blue box, e2: room

/// Looks again every few milliseconds until it is true; false after the deadline.
inline bool waitUntil(const std::function<bool()>& predicate, double timeout_s = 60.0) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  while (!predicate()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

/// Exit status of all tests, with ROS up and callbacks in threads of their own.
inline int runRosTests(int argc, char** argv, const char* name) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, name);
  ros::AsyncSpinner spinner(4);
  spinner.start();
  const int result = RUN_ALL_TESTS();
  spinner.stop();
  ros::shutdown();
  return result;
}

struct RobotMessages {
  Stamp stamp;
  sensor_msgs::ImagePtr color;
  sensor_msgs::ImagePtr depth;
  sensor_msgs::CameraInfoPtr info;
  msg::SegmentationPtr segmentation;
  geometry_msgs::TransformStamped transform;
};

inline Embedding makeUnit(int axis) { return Embedding::Unit(kEmbeddingSize, axis); }

inline std::vector<Solid> makeRoom() {
  const cv::Vec3b wall(200, 190, 170);
  return {makePlane({0, 0, 0}, {0, 0, 1}, {120, 120, 110}),
          makePlane({0, 0, 2.5}, {0, 0, -1}, {230, 230, 230}),
          makePlane({3, 0, 0}, {-1, 0, 0}, wall),
          makePlane({-3, 0, 0}, {1, 0, 0}, wall),
          makePlane({0, 3, 0}, {0, -1, 0}, wall),
          makePlane({0, -3, 0}, {0, 1, 0}, wall),
          makeBox(makeAabb({1.2, 0.5, 0.0}, {1.8, 1.1, 0.7}), {210, 30, 30}, 1),
          makeBox(makeAabb({1.2, -1.1, 0.0}, {1.8, -0.5, 0.7}), {30, 30, 210}, 2)};
}

/// The robot looks at the boxes while it moves sideways (frames 0 to 39); then it turns round in
/// two corners of the room, 20 frames each.
inline Pose computePose(int index) {
  if (index < 40) {
    const double y_m = -0.6 + 0.03 * index;
    return lookAt({-1.6, y_m, 1.3}, {1.5, 0.3 * y_m, 0.2});
  }
  const Eigen::Vector3d eye =
      index < 60 ? Eigen::Vector3d(-1.8, -1.2, 1.3) : Eigen::Vector3d(0.0, 1.8, 1.3);
  const double angle_rad = 2.0 * M_PI * index / 20.0;
  return lookAt(eye,
                eye + Eigen::Vector3d(2.0 * std::cos(angle_rad), 2.0 * std::sin(angle_rad), -0.8));
}

inline RobotMessages makeMessages(int index, double start_s = 100.0) {
  const CameraModel camera{96, 72, 75.0, 75.0, 47.5, 35.5};
  const Rendering rendering = render(makeRoom(), camera, computePose(index));
  RobotMessages messages;
  messages.stamp = Stamp::fromSeconds(start_s + 0.1 * index);
  const std::string frame = "camera_color_optical_frame";
  messages.color =
      ros_interface::toImageMessage(rendering.frame.color.image, "rgb8", messages.stamp, frame);
  messages.depth =
      ros_interface::toImageMessage(rendering.frame.depth.image, "32FC1", messages.stamp, frame);
  messages.info = boost::make_shared<sensor_msgs::CameraInfo>();
  messages.info->header = messages.color->header;
  messages.info->width = 96;
  messages.info->height = 72;
  messages.info->K = {75.0, 0, 47.5, 0, 75.0, 35.5, 0, 0, 1};
  Segmentation segmentation;
  segmentation.stamp = messages.stamp;
  segmentation.labels = rendering.labels;
  segmentation.embeddings.resize(2, kEmbeddingSize);
  segmentation.embeddings.row(0) = makeUnit(0);
  segmentation.embeddings.row(1) = makeUnit(1);
  segmentation.confidences = {0.9F, 0.9F};
  segmentation.image_embedding = makeUnit(2);
  messages.segmentation = ros_interface::toMessage(segmentation, frame);
  messages.transform.header = messages.color->header;
  messages.transform.header.frame_id = "world";
  messages.transform.child_frame_id = frame;
  messages.transform.transform = ros_interface::toTransform(computePose(index));
  return messages;
}

/// A robot that stands still, and a segmenter that cuts the image into a grid of 144 segments.
inline RobotMessages makeGridMessages(int index, double start_s = 100.0) {
  RobotMessages messages = makeMessages(0, start_s + 0.1 * index);
  constexpr int kWidth_px = 6;
  constexpr int kHeight_px = 8;
  Segmentation segmentation;
  segmentation.stamp = messages.stamp;
  segmentation.labels = cv::Mat::zeros(72, 96, CV_16UC1);
  int label = 0;
  for (int y = 0; y < 72; y += kHeight_px) {
    for (int x = 0; x < 96; x += kWidth_px) {
      segmentation.labels(cv::Rect(x, y, kWidth_px, kHeight_px)).setTo(++label);
    }
  }
  segmentation.embeddings.setZero(label, kEmbeddingSize);
  segmentation.embeddings.col(0).setOnes();
  segmentation.confidences.assign(static_cast<std::size_t>(label), 0.9F);
  messages.segmentation = ros_interface::toMessage(segmentation, "camera_color_optical_frame");
  return messages;
}

/// Publishes what a robot would.
class Robot {
 public:
  Robot()
      : color_(handle_.advertise<sensor_msgs::Image>("camera/color/image_raw", 100)),
        depth_(
            handle_.advertise<sensor_msgs::Image>("camera/aligned_depth_to_color/image_raw", 100)),
        info_(handle_.advertise<sensor_msgs::CameraInfo>("camera/color/camera_info", 100)),
        segmentation_(handle_.advertise<msg::Segmentation>("segmentation", 100)) {}

  bool waitForSubscribers(std::uint32_t count) {
    return waitUntil([&] {
      return color_.getNumSubscribers() >= count && depth_.getNumSubscribers() >= count &&
             info_.getNumSubscribers() >= count;
    });
  }
  bool waitForSegmentationSubscribers(std::uint32_t count) {
    return waitUntil([&] { return segmentation_.getNumSubscribers() >= count; });
  }

  void publish(const RobotMessages& messages, bool with_transform = true) {
    if (with_transform) tf_.sendTransform(messages.transform);
    color_.publish(sensor_msgs::ImageConstPtr(messages.color));
    depth_.publish(sensor_msgs::ImageConstPtr(messages.depth));
    info_.publish(sensor_msgs::CameraInfoConstPtr(messages.info));
    segmentation_.publish(msg::SegmentationConstPtr(messages.segmentation));
  }

 private:
  ros::NodeHandle handle_;
  ros::Publisher color_;
  ros::Publisher depth_;
  ros::Publisher info_;
  ros::Publisher segmentation_;
  tf2_ros::TransformBroadcaster tf_;
};

/// Keeps every message of a topic.
template <typename Message>
class Recorder {
 public:
  explicit Recorder(const std::string& topic)
      : subscriber_(ros::NodeHandle().subscribe<Message>(
            topic, 1000, [this](const boost::shared_ptr<const Message>& message) {
              const std::lock_guard<std::mutex> lock(mutex_);
              messages_.push_back(message);
            })) {}
  std::vector<boost::shared_ptr<const Message>> messages() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_;
  }
  bool waitFor(const std::function<bool(const Message&)>& predicate, double timeout_s = 60.0) {
    return waitUntil(
        [&] {
          for (const auto& message : messages()) {
            if (predicate(*message)) return true;
          }
          return false;
        },
        timeout_s);
  }
  /// Ends the subscription; the messages stay.
  void stop() { subscriber_.shutdown(); }
  bool waitForPublisher() {
    return waitUntil([&] { return subscriber_.getNumPublishers() > 0; });
  }

 private:
  mutable std::mutex mutex_;
  std::vector<boost::shared_ptr<const Message>> messages_;
  ros::Subscriber subscriber_;
};

/// Waits for a line of the log that holds all the parts.
inline bool waitForLog(Recorder<rosgraph_msgs::Log>& log, const std::vector<std::string>& parts) {
  return log.waitFor([&](const rosgraph_msgs::Log& line) {
    for (const auto& part : parts) {
      if (line.msg.find(part) == std::string::npos) return false;
    }
    return true;
  });
}

/// The newest diagnostics of a stage.
inline std::map<std::string, std::string> findDiagnostics(
    const Recorder<diagnostic_msgs::DiagnosticArray>& recorder, const std::string& stage) {
  std::map<std::string, std::string> lines;
  for (const auto& message : recorder.messages()) {
    for (const auto& status : message->status) {
      if (status.name != stage + ": stage") continue;
      lines.clear();
      for (const auto& entry : status.values) lines[entry.key] = entry.value;
    }
  }
  return lines;
}

inline void writeTaskFile(const std::string& path, const std::vector<std::string>& names,
                          int first_axis) {
  std::ofstream file(path);
  file << "tasks:\n";
  for (std::size_t i = 0; i < names.size(); ++i) {
    file << "  - {name: " << names[i] << ", embedding: [";
    for (int axis = 0; axis < kEmbeddingSize; ++axis) {
      file << (axis == 0 ? "" : ", ") << (axis == first_axis + static_cast<int>(i) ? 1 : 0);
    }
    file << "]}\n";
  }
}

inline bool load(nodelet::Loader& loader, const std::string& name, const std::string& type) {
  return loader.load("/" + name, "task_scene_graph/" + type, ros::names::getRemappings(), {});
}

/// The tasks of both boxes, written into a folder, and where the stages save: for stages to come.
inline void setChainParameters(const std::filesystem::path& folder, const std::string& output) {
  const std::string tasks = (folder / "objects.yaml").string();
  writeTaskFile(tasks, {"red box", "blue box"}, 0);
  ros::param::set("/scene_graph/object_tasks", tasks);
  ros::param::set("/scene_graph/output", output);
  ros::param::set("/mesh_fusion/output", output);
}

/// Loads the stages after the segmenter, and waits until all are connected. May fail fatally.
inline void startStages(nodelet::Loader& loader, Robot& robot, Recorder<msg::Tracks>& tracks,
                        Recorder<msg::SceneGraph>& graphs) {
  ASSERT_TRUE(load(loader, "tracker", "Tracker"));
  ASSERT_TRUE(load(loader, "mesh_fusion", "MeshFusion"));
  ASSERT_TRUE(load(loader, "scene_graph", "SceneGraph"));
  ASSERT_TRUE(robot.waitForSubscribers(1));
  ASSERT_TRUE(robot.waitForSegmentationSubscribers(1));
  ASSERT_TRUE(tracks.waitForPublisher());
  ASSERT_TRUE(graphs.waitForPublisher());
}

/// Whether the tracker answers to these messages.
inline bool waitForTracks(Recorder<msg::Tracks>& tracks, const RobotMessages& messages) {
  return tracks.waitFor([&](const msg::Tracks& answer) {
    return ros_interface::toStamp(answer.header.stamp) == messages.stamp;
  });
}

}  // namespace tsg::test
