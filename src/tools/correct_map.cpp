// SPDX-License-Identifier: BSD-3-Clause
// Lets a saved map follow a corrected trajectory.
#include "task_scene_graph/trajectory/correct_map.h"

#include <iostream>
#include <optional>
#include <string>

#include "command_line.h"
#include "saved_map.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/map/settings.h"
#include "task_scene_graph/trajectory/outside_correction.h"

namespace options = boost::program_options;
using namespace tsg;

namespace {

struct Arguments {
  std::string map;
  std::string trajectory;
  std::string old;
  std::string output;
  trajectory::OutsideCorrectionConfig how;
};

std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  options::options_description description(
      "Lets a saved map follow a corrected trajectory: objects, places, mesh, free space and "
      "occupancy\nmap move with the poses from which they were seen, and what then lies on one "
      "another is joined.\nIds stay. Trajectories are files in TUM's format: stamp tx ty tz qx qy "
      "qz qw, in the map's frame.\nusage: correct_map --map FOLDER --trajectory NEW.tum [--old "
      "OLD.tum] --output FOLDER\noptions");
  description.add_options()("help,h", "print this")(
      "map", tools::pathOption(arguments.map)->required(), "folder of the map")(
      "trajectory", tools::pathOption(arguments.trajectory)->required(),
      "the corrected poses, of the camera; with --old of any body that carries it")(
      "old", tools::pathOption(arguments.old),
      "the poses of that body before; without it, those of the map's own trajectory.txt")(
      "output", tools::pathOption(arguments.output)->required(),
      "folder to write; may be that of the map")(
      "max-gap-s", options::value(&arguments.how.max_gap_s)->default_value(arguments.how.max_gap_s),
      "corrected poses where the old ones are further apart are passed over")(
      "max-motion-m",
      options::value(&arguments.how.max_motion_m)->default_value(arguments.how.max_motion_m),
      "refuse a correction that moves the camera farther");
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  return arguments;
}

trajectory::OutsideCorrection readCorrection(const Arguments& arguments, const map::Map& map) {
  const Trajectory corrected = loadTumTrajectory(arguments.trajectory);
  const Trajectory reported =
      arguments.old.empty() ? *map.trajectory() : loadTumTrajectory(arguments.old);
  try {
    return trajectory::computeOutsideCorrection(*map.trajectory(), reported, corrected,
                                                map.worldFrame(), arguments.how);
  } catch (const std::invalid_argument& e) {
    throw std::runtime_error("map '" + arguments.map + "' cannot follow '" + arguments.trajectory +
                             "': " + e.what());
  }
}

void run(const Arguments& arguments) {
  map::Map loaded = tools::loadMap(arguments.map);
  loaded.setOccupancy(map::readOccupancy(
      arguments.map,
      map::readSettings<mapping::OccupancyConfig>(arguments.map, "mesh_fusion", "occupancy")));
  const auto correction = readCorrection(arguments, loaded);
  auto corrected = trajectory::correctMap(loaded, correction.before, correction.correction);
  if (!correction.correction.isIdentity()) {
    trajectory::joinMap(
        map::readSettings<places::PlacesConfig>(arguments.map, "mesh_fusion", "places"),
        corrected.map);
  }
  const auto files = map::writeMap(arguments.output, corrected.map);
  std::cout << formatCount(correction.before.list().size(), "keyframe") << " moved by up to "
            << correction.max_motion_m << " m and " << correction.max_turn_rad << " rad; "
            << formatCount(corrected.num_moved_primitives, "primitive") << " of "
            << loaded.primitives().size() << " and "
            << formatCount(corrected.num_moved_blocks, "mesh block") << " of "
            << loaded.meshBlocks().size() << " followed; "
            << formatCount(loaded.objectClusters().size(), "cluster") << " became "
            << corrected.map.objectClusters().size() << '\n'
            << describeWritten(arguments.output, files) << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("correct_map", argc, argv, parseArguments, run);
}
