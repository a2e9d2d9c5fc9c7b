// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/run_nodelets.h"

int main(int argc, char** argv) {
  return tsg::ros_interface::runNodelets(argc, argv, "segmenter",
                                         {{"task_scene_graph/Segmenter", ""}});
}
