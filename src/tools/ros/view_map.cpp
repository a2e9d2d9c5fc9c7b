// SPDX-License-Identifier: BSD-3-Clause
// Shows a saved map: publishes what the live chain publishes of it, answers questions, and waits.
#include <ros/ros.h>

#include <memory>
#include <optional>
#include <string>

#include "../../nodelets/saved_map_stage.h"
#include "../command_line.h"
#include "../saved_map.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/map/settings.h"
#include "task_scene_graph/ros/camera_publisher.h"
#include "task_scene_graph/ros/late_subscribers.h"
#include "task_scene_graph/ros/mesh_publisher.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/stage_report.h"

namespace options = boost::program_options;
using namespace tsg;

namespace {

std::optional<std::string> parseArguments(int argc, char** argv) {
  std::string folder;
  options::options_description description(
      "Shows a saved map to rviz and others as a running chain would, in its namespace: mesh,\n"
      "mesh_blocks, place_graph, camera_markers, floor_<n>/map, the graph with tasks, questions\n"
      "and sliders (scene_graph/...), plan_path. Nothing is mapped, and nothing is written.\n"
      "usage: view_map --map FOLDER\noptions");
  description.add_options()("help,h", "print this")("map", tools::pathOption(folder)->required(),
                                                    "folder of the map");
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  return folder;
}

mapping::MeshUpdate toUpdate(const map::Map& map) {
  mapping::MeshUpdate update;
  update.changed = map.meshBlocks();
  return update;
}

mapping::MeshTable toTable(const map::Map& map) {
  std::vector<mapping::MeshTable::Entry> entries;
  for (const auto& block : map.meshBlocks()) {
    entries.push_back({block.block, mapping::StoredMesh(block.mesh)});
  }
  return mapping::MeshTable().with(entries);
}

/// Without the networks that the map was made with, there are no questions in words.
std::shared_ptr<language::WordEncoder> makeEncoder(const std::string& folder) {
  const std::string models = map::findModels(folder).string();
  try {
    return std::make_shared<language::WordEncoder>(models);
  } catch (const std::exception& e) {
    ROS_WARN_STREAM("no tasks and questions in words: " << e.what());
    return std::make_shared<language::WordEncoder>("");
  }
}

void publish(const map::Map& map, const std::string& folder) {
  ros::NodeHandle handle;
  ros_interface::StageReport report(ros::this_node::getName());
  ros_interface::LateSubscribers late(report);
  const double voxel_size_m = map.meshVoxelSize() > 0.0 ? map.meshVoxelSize() : 0.05;
  ros_interface::MeshPublisher mesh(handle, late, report, map.worldFrame(),
                                    voxel_size_m * mapping::kBlockSide);
  mesh.add(toUpdate(map), toTable(map), map.stamp());
  ros_interface::CameraPublisher camera(handle, late, map.worldFrame());
  camera.restore(*map.trajectory());
  ros::Publisher places = handle.advertise<msg::PlaceGraph>("place_graph", 1, true);
  places.publish(ros_interface::toMessage(*map.places(), map.worldFrame()));
  const nodelets::SavedMapStage stage(handle, map, folder, makeEncoder(folder), report);
  ROS_INFO_STREAM("map in frame '" << map.worldFrame() << "' of " << map.primitives().size()
                                   << " object primitives and " << map.places()->places.size()
                                   << " places; shown until this ends");
  ros::spin();
  mesh.stop();
  late.stop();
}

void run(const std::string& folder) { publish(tools::loadMap(folder), folder); }

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "view_map", ros::init_options::AnonymousName);
  return tools::runProgram("view_map", argc, argv, parseArguments, run);
}
