// SPDX-License-Identifier: BSD-3-Clause
// Shows a saved map: publishes what the live chain publishes of it, latched, and waits.
#include <ros/ros.h>

#include <iostream>
#include <optional>
#include <string>

#include "../command_line.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/ros/late_subscribers.h"
#include "task_scene_graph/ros/mesh_publisher.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/scene_graph_conversions.h"
#include "task_scene_graph/ros/scene_graph_markers.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/storey_publisher.h"

namespace options = boost::program_options;
using namespace tsg;

namespace {

std::optional<std::string> parseArguments(int argc, char** argv) {
  std::string folder;
  options::options_description description(
      "Publishes a saved map for rviz and others, latched: mesh, mesh_blocks, scene_graph,\n"
      "scene_graph_markers, place_graph and floor_<n>/map, in its namespace.\n"
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

template <typename Message>
ros::Publisher publishLatched(ros::NodeHandle& handle, const std::string& topic,
                              const Message& message) {
  ros::Publisher publisher = handle.advertise<Message>(topic, 1, true);
  publisher.publish(message);
  return publisher;
}

void publish(const map::Map& map) {
  ros::NodeHandle handle;
  ros_interface::StageReport report(ros::this_node::getName());
  ros_interface::LateSubscribers late(report);
  const double voxel_size_m = map.meshVoxelSize() > 0.0 ? map.meshVoxelSize() : 0.05;
  ros_interface::MeshPublisher mesh(handle, late, report, map.worldFrame(),
                                    voxel_size_m * mapping::kBlockSide);
  mesh.add(toUpdate(map), toTable(map), map.stamp());
  ros_interface::StoreyPublisher storeys(handle, late, map.worldFrame());
  storeys.update(map.placeMemory()->plan, map.stamp());
  const scene_graph::SceneGraph graph = map::computeSceneGraph(map);
  ros_interface::SceneGraphMarkers markers({}, map.worldFrame());
  ros_interface::TaskNumbers numbers;
  for (const auto& task : graph.object_tasks) numbers.find(task);
  const ros::Publisher publishers[] = {
      publishLatched(handle, "scene_graph",
                     *ros_interface::toMessage(graph, map.worldFrame(), false)),
      publishLatched(handle, "scene_graph_markers", markers.update(graph, numbers)),
      publishLatched(handle, "place_graph",
                     *ros_interface::toMessage(*map.places(), map.worldFrame()))};
  ROS_INFO_STREAM("map in frame '" << map.worldFrame() << "': " << graph.objects.size()
                                   << " objects, " << graph.places->places.size() << " places, "
                                   << graph.regions.size() << " regions; shown until this ends");
  ros::spin();
  mesh.stop();
  late.stop();
}

void run(const std::string& folder) {
  const map::LoadedMap loaded = map::loadMap(folder);
  for (const auto& note : loaded.notes) std::cerr << "map '" << folder << "': " << note << '\n';
  publish(loaded.map);
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "view_map", ros::init_options::AnonymousName);
  return tools::runProgram("view_map", argc, argv, parseArguments, run);
}
