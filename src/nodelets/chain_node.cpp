// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>
#include <vector>

#include "task_scene_graph/ros/run_nodelets.h"

namespace {

constexpr const char* kRecorded = "--recorded-segmentation";
constexpr const char* kUsage =
    "usage: chain_node [--recorded-segmentation] [name:=other_name...]\n"
    "The whole chain in one process, so that images are never copied: the nodelets segmenter,\n"
    "tracker, mesh_fusion and scene_graph in this node's namespace, each with the parameters of "
    "its\n"
    "own. It is a nodelet manager, into which others (a camera driver) can be loaded.\n"
    "  --recorded-segmentation  no segmenter: a bag or another node publishes `segmentation`\n"
    "  --help                   this text\n"
    "launch/task_scene_graph.launch starts it with what it needs; docs/ros_interface.md lists\n"
    "topics and services, docs/parameters.md the parameters.\n"
    "Exit status: 0; 1 if a stage did not start, or if map files were asked for and none "
    "written.\n";

}  // namespace

int main(int argc, char** argv) {
  std::vector<tsg::ros_interface::NodeletSpec> nodelets = {
      {"task_scene_graph/Segmenter", "segmenter"},
      {"task_scene_graph/Tracker", "tracker"},
      {"task_scene_graph/MeshFusion", "mesh_fusion"},
      {"task_scene_graph/SceneGraph", "scene_graph"}};
  const bool is_recorded = std::any_of(
      argv, argv + argc, [](const char* word) { return std::string(word) == kRecorded; });
  if (is_recorded) nodelets.erase(nodelets.begin());
  return tsg::ros_interface::runNodelets(argc, argv, {"task_scene_graph", kUsage, nodelets, true},
                                         {kRecorded});
}
