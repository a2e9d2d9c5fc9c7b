// SPDX-License-Identifier: BSD-3-Clause
// Files of intrinsics, used for images of a fixed size, rectified and not.
#include <cmath>
#include <stdexcept>

#include "fuzzer.h"
#include "task_scene_graph/ros/camera_intrinsics.h"

namespace {

namespace fuzz = tsg::fuzz;
using tsg::ros_interface::Rectification;

std::string make(fuzz::Mutator& mutator) {
  static const std::vector<std::string> corpus{
      "525.0, 525.0, 15.5, 11.5",
      "525 525 15.5 11.5 32 24",
      "525 0 15.5\n0 525 11.5\n0 0 1\n",
      "[525, 0, 15.5, 0; 0, 525, 11.5, 0; 0, 0, 1, 0; 0, 0, 0, 1]",
      "fx: 525.0\nfy: 525.0\ncx: 15.5\ncy: 11.5\nwidth: 32\nheight: 24\n",
      "image_width: 32\nimage_height: 24\ncamera_name: rgb\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: [525, 0, 15.5, 0, 525, 11.5, 0, 0, 1]\ndistortion_model: plumb_bob\n"
      "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, -0.2, 0.001, 0.002, 0.05]\n"
      "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
      "projection_matrix:\n  rows: 3\n  cols: 4\n"
      "  data: [520, 0, 15.4, 0, 0, 521, 11.6, 0, 0, 0, 1, 0]\n"};
  return fuzz::makeYaml(mutator, mutator.pickFrom(corpus));
}

void use(const sensor_msgs::CameraInfo& info, Rectification rectification,
         const std::string& name) {
  const cv::Size size(32, 24);
  const auto intrinsics = tsg::ros_interface::toIntrinsics(info, size, rectification, name);
  intrinsics.camera.validate();
  if (intrinsics.rectification) {
    intrinsics.rectification->applyNearest(cv::Mat::ones(size, CV_16UC1));
  }
}

void readInput(const std::string& path) {
  const auto info = tsg::ros_interface::loadIntrinsics(path);
  for (const auto rectification :
       {Rectification::kIgnored, Rectification::kDone, Rectification::kWanted}) {
    use(info, rectification, "intrinsics '" + path + "'");
  }
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv,
                         fuzz::makeFileReader("intrinsics", "camera.yaml", make, readInput));
}
