// SPDX-License-Identifier: BSD-3-Clause
// camera_info, used for images of a fixed size, rectified and not.
#include "fuzzer.h"
#include "message_mutator.h"
#include "sample_messages.h"
#include "task_scene_graph/ros/camera_intrinsics.h"

namespace {

namespace fuzz = tsg::fuzz;
using tsg::ros_interface::Rectification;

constexpr const char* kTopic = "/camera/camera_info";

std::string make(fuzz::Mutator& mutator) {
  sensor_msgs::CameraInfo info = fuzz::makeCameraInfo();
  if (mutator.isOneIn(3)) {
    info.distortion_model = "equidistant";
    info.D.resize(4);
  }
  return fuzz::makeMutated(mutator, info);
}

void readInput(const std::string& input) {
  const auto info = fuzz::fromBytes<sensor_msgs::CameraInfo>(input);
  const cv::Size size(fuzz::kWidth, fuzz::kHeight);
  for (const auto rectification :
       {Rectification::kIgnored, Rectification::kDone, Rectification::kWanted}) {
    const auto intrinsics = tsg::ros_interface::toIntrinsics(*info, size, rectification, kTopic);
    intrinsics.camera.validate();
    if (intrinsics.rectification) intrinsics.rectification->applyNearest(fuzz::makeDepth());
  }
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv, {"camera_info", kTopic, make, readInput});
}
