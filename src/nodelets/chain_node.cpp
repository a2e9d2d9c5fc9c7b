// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <vector>

#include "task_scene_graph/ros/run_nodelets.h"

/// The whole chain in one process, so that images are never copied. usage: chain_node
/// [--recorded-segmentation]: the segmenter is left out, another node or a bag publishes
/// `segmentation`.
int main(int argc, char** argv) {
  using tsg::ros_interface::NodeletSpec;
  std::vector<NodeletSpec> nodelets = {{"task_scene_graph/Segmenter", "segmenter"},
                                       {"task_scene_graph/Tracker", "tracker"},
                                       {"task_scene_graph/MeshFusion", "mesh_fusion"},
                                       {"task_scene_graph/SceneGraph", "scene_graph"}};
  const bool is_recorded = argc > 1 && std::strcmp(argv[1], "--recorded-segmentation") == 0;
  if (is_recorded) nodelets.erase(nodelets.begin());
  return tsg::ros_interface::runNodelets(argc, argv, "task_scene_graph", nodelets);
}
