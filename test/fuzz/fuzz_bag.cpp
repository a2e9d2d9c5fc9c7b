// SPDX-License-Identifier: BSD-3-Clause
// Whole bags, changed in their bytes and in their messages, as process_bag reads them.
#include <rosbag/bag.h>

#include <stdexcept>

#include "fuzzer.h"
#include "message_mutator.h"
#include "sample_messages.h"
#include "task_scene_graph/ros/rgbd_bag.h"

namespace {

namespace fuzz = tsg::fuzz;
namespace ros_interface = tsg::ros_interface;

ros_interface::InputConfig makeConfig() {
  ros_interface::InputConfig config;
  config.color_topic = "/color";
  config.depth_topic = "/depth";
  config.camera_info_topic = "/info";
  return config;
}

/// @param mutator  null: nothing is changed
void writeBag(const std::string& path, fuzz::Mutator* mutator) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  const auto write = [&](const std::string& topic, double seconds, auto message) {
    if (mutator != nullptr && mutator->isOneIn(6)) fuzz::mutateMessage(*mutator, message);
    bag.write(topic, ros::Time(seconds), message);
  };
  for (const double seconds : {10.0, 11.0}) {
    tf2_msgs::TFMessage tf;
    tf.transforms = {fuzz::makeTransform("world", "camera", seconds)};
    write("/tf", seconds, tf);
    write("/info", seconds, fuzz::makeCameraInfo());
    write("/color", seconds, fuzz::makeImage("rgb8", fuzz::makeColor(), seconds));
    write("/depth", seconds, fuzz::makeImage("16UC1", fuzz::makeDepth(), seconds));
  }
}

std::string make(fuzz::Mutator& mutator) {
  static const std::string path = (fuzz::scratchFolder() / "made.bag").string();
  static const std::string corpus = [] {
    writeBag(path, nullptr);
    return fuzz::readFile(path);
  }();
  static const std::vector<std::string> words{
      "op=\x02", "size=", "topic=/color",     "conn=", "none", "bz2", "lz4", "index_pos=",
      "\n",      "=",     "sensor_msgs/Image"};
  if (mutator.isOneIn(3)) {
    writeBag(path, &mutator);
    return fuzz::readFile(path);
  }
  std::string bag = corpus;
  mutator.mutateBytes(words, bag);
  return bag;
}

void readInput(const std::string& path) {
  ros_interface::RgbdBag bag({path}, makeConfig(), true);
  const auto on_frame = [](const tsg::RgbdFramePtr& frame, const tsg::SegmentationPtr&) {
    frame->validate();
    return true;
  };
  bag.forEachFrame(on_frame, [](std::size_t) {});
  for (const auto& [reason, drops] : bag.drops()) {
    const bool is_named = drops.example.empty() || drops.example.find('/') != std::string::npos ||
                          drops.example.find("no transform from") != std::string::npos;
    if (!is_named) throw std::logic_error("dropped without naming the topic: " + drops.example);
  }
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv, fuzz::makeFileReader("bag", "input.bag", make, readInput));
}
