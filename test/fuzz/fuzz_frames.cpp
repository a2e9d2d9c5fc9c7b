// SPDX-License-Identifier: BSD-3-Clause
// The input of a camera, message by message: what becomes of it is a frame that holds together, or
// a drop that names its topic.
#include <stdexcept>

#include "fuzzer.h"
#include "message_mutator.h"
#include "records.h"
#include "sample_messages.h"
#include "task_scene_graph/ros/frame_assembler.h"

namespace {

namespace fuzz = tsg::fuzz;
namespace ros_interface = tsg::ros_interface;

std::string make(fuzz::Mutator& mutator) {
  const auto prepare = [&](auto message) {
    if (mutator.isOneIn(4)) fuzz::mutateMessage(mutator, message);
    return fuzz::toBytes(message);
  };
  fuzz::Records records;
  if (!mutator.isOneIn(4)) records.emplace_back('i', prepare(fuzz::makeCameraInfo()));
  for (int i = 0; i < 3; ++i) {
    records.emplace_back('c', prepare(fuzz::makeImage("rgb8", fuzz::makeColor(), 10.0 + i)));
    records.emplace_back('d', prepare(fuzz::makeImage("16UC1", fuzz::makeDepth(), 10.0 + i)));
  }
  if (mutator.isOneIn(2)) records.emplace_back('i', prepare(fuzz::makeCameraInfo()));
  std::string text = fuzz::joinRecords(records);
  text.insert(0, 1, static_cast<char>('0' + mutator.pick(6)));
  return text;
}

ros_interface::InputConfig makeConfig(char choice) {
  ros_interface::InputConfig config;
  config.rectify = choice % 2 == 0;
  config.match_size = static_cast<ros_interface::MatchSize>(choice % 3);
  return config;
}

ros_interface::FrameAssembler::Callbacks makeCallbacks() {
  ros_interface::FrameAssembler::Callbacks callbacks;
  callbacks.on_frame = [](const ros_interface::AssembledFrame& frame) {
    try {
      frame.frame->validate();
    } catch (const std::exception&) {
      return;  // counted by whoever adds the pose
    }
    frame.frame->depth.at(frame.frame->camera.width_px - 1, frame.frame->camera.height_px - 1);
  };
  callbacks.on_drop = [](const std::string&, const std::string& text, std::uint64_t) {
    const bool is_named = text.empty() || text.find("/camera/") != std::string::npos;
    if (!is_named) throw std::logic_error("dropped without naming the topic: " + text);
  };
  callbacks.on_warning = [](const std::string&, const std::string&) {};
  callbacks.on_jump_back = [] {};
  callbacks.on_image = [](bool, const void*) {};
  return callbacks;
}

void readInput(const std::string& input) {
  if (input.empty()) return;
  ros_interface::FrameAssembler assembler(
      makeConfig(input[0]), {"/camera/color", "/camera/depth", "/camera/info"}, makeCallbacks());
  using ros_interface::SourceImage;
  for (const auto& [type, bytes] : fuzz::splitRecords(input.substr(1))) {
    if (type == 'i') {
      assembler.addCameraInfo(fuzz::fromBytes<sensor_msgs::CameraInfo>(bytes));
    } else if (type == 'c') {
      assembler.addColor(SourceImage(fuzz::fromBytes<sensor_msgs::Image>(bytes)));
    } else {
      assembler.addDepth(SourceImage(fuzz::fromBytes<sensor_msgs::Image>(bytes)));
    }
  }
  assembler.flush();
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv, {"frames", "/camera/", make, readInput});
}
