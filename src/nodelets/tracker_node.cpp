// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/run_nodelets.h"

int main(int argc, char** argv) {
  constexpr const char* kUsage =
      "usage: tracker_node [name:=other_name...] [_parameter:=value...]\n"
      "Follows segments from image to image: RGB-D images, tf and segmentation -> tracks.\n"
      "Parameters are private ones (_config_file:=FILE.yaml reads a whole file of them);\n"
      "docs/parameters.md or `rosrun task_scene_graph list_parameters` lists them, docs/\n"
      "ros_interface.md the topics. launch/task_scene_graph.launch starts all stages.\n";
  return tsg::ros_interface::runNodelets(argc, argv,
                                         {"tracker", kUsage, {{"task_scene_graph/Tracker", ""}}});
}
