// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/run_nodelets.h"

int main(int argc, char** argv) {
  constexpr const char* kUsage =
      "usage: scene_graph_node [name:=other_name...] [_parameter:=value...]\n"
      "Clusters primitives and places for tasks: object_primitives, place_graph -> scene_graph.\n"
      "Parameters are private ones (_config_file:=FILE.yaml reads a whole file of them);\n"
      "docs/parameters.md or `rosrun task_scene_graph list_parameters` lists them, docs/\n"
      "ros_interface.md the topics. launch/task_scene_graph.launch starts all stages.\n";
  return tsg::ros_interface::runNodelets(
      argc, argv, {"scene_graph", kUsage, {{"task_scene_graph/SceneGraph", ""}}, true});
}
