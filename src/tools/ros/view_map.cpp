// SPDX-License-Identifier: BSD-3-Clause
// Shows a saved map: publishes what the live chain publishes of it, latched, and plans paths in it.
#include <ros/ros.h>

#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "../command_line.h"
#include "navigation_stage.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/map/settings.h"
#include "task_scene_graph/ros/late_subscribers.h"
#include "task_scene_graph/ros/mesh_publisher.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/scene_graph_conversions.h"
#include "task_scene_graph/ros/scene_graph_markers.h"
#include "task_scene_graph/ros/stage_report.h"

namespace options = boost::program_options;
using namespace tsg;

namespace {

struct Arguments {
  std::string map;
  ros_interface::MarkerConfig markers;
};

std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  options::options_description description(
      "Publishes a saved map for rviz and others, latched: mesh, mesh_blocks, scene_graph,\n"
      "scene_graph_markers, place_graph and floor_<n>/map, in its namespace; serves plan_path "
      "there\n"
      "and publishes path. Paths begin where the camera was last, unless the request says where.\n"
      "usage: view_map --map FOLDER\noptions");
  double& text_height_m = arguments.markers.text_height_m;
  description.add_options()("help,h", "print this")(
      "map", tools::pathOption(arguments.map)->required(), "folder of the map")(
      "text-height", options::value(&text_height_m)->default_value(text_height_m),
      "metres; letters of the labels");
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  config::validate(arguments.markers, "markers");
  return arguments;
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

/// Serves paths in the map, as mesh_fusion does in its own.
std::unique_ptr<nodelets::NavigationStage> servePaths(const map::Map& map,
                                                      const planning::PlannerConfig& planner,
                                                      const ros::NodeHandle& handle,
                                                      ros_interface::StageReport& report) {
  const nodelets::NavigationStage::Options options{planner, map.worldFrame()};
  auto stage = std::make_unique<nodelets::NavigationStage>(handle, options, report);
  const auto& poses = map.trajectory()->poses();
  if (!poses.empty()) stage->setCamera(poses.rbegin()->second.translation());
  stage->setMap(*map.places(), map.placeMemory()->plan);
  return stage;
}

void publish(const map::Map& map, const planning::PlannerConfig& planner,
             const ros_interface::MarkerConfig& marker_config) {
  ros::NodeHandle handle;
  ros_interface::StageReport report(ros::this_node::getName());
  ros_interface::LateSubscribers late(report);
  const double voxel_size_m = map.meshVoxelSize() > 0.0 ? map.meshVoxelSize() : 0.05;
  ros_interface::MeshPublisher mesh(handle, late, report, map.worldFrame(),
                                    voxel_size_m * mapping::kBlockSide);
  mesh.add(toUpdate(map), toTable(map), map.stamp());
  const auto navigation = servePaths(map, planner, handle, report);
  const scene_graph::SceneGraph graph = map::computeSceneGraph(map);
  ros_interface::SceneGraphMarkers markers(marker_config, map.worldFrame());
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
  navigation->stop();
  mesh.stop();
  late.stop();
}

void run(const Arguments& arguments) {
  const map::LoadedMap loaded = map::loadMap(arguments.map);
  for (const auto& note : loaded.notes) {
    std::cerr << "map '" << arguments.map << "': " << note << '\n';
  }
  publish(loaded.map,
          map::readSettings<planning::PlannerConfig>(arguments.map, "mesh_fusion", "planner"),
          arguments.markers);
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "view_map", ros::init_options::AnonymousName);
  return tools::runProgram("view_map", argc, argv, parseArguments, run);
}
