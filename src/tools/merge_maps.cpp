// SPDX-License-Identifier: BSD-3-Clause
// Makes one map of two saved ones.
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "command_line.h"
#include "saved_map.h"
#include "task_scene_graph/loops/map_alignment.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/map/merge.h"
#include "task_scene_graph/map/settings.h"

namespace options = boost::program_options;
using namespace tsg;

namespace {

struct Arguments {
  std::string a;
  std::string b;
  std::string output;
  std::vector<double> transform;
  bool align = false;
};

std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  options::options_description description(
      "Makes one map of two saved ones: A with what only B has seen, in A's coordinates, with A's\n"
      "tasks, settings and ids. Things that both have seen become one.\n"
      "usage: merge_maps A B OUT [--transform X Y Z QX QY QZ QW | --align]\noptions");
  description.add_options()("help,h", "print this")("a", tools::pathOption(arguments.a)->required(),
                                                    "folder of the first map")(
      "b", tools::pathOption(arguments.b)->required(), "folder of the second map")(
      "out", tools::pathOption(arguments.output)->required(), "folder to write; may be A or B")(
      "transform", options::value(&arguments.transform)->multitoken(),
      "from B's coordinates to A's, metres and a quaternion, upright; without it both must be in "
      "the same frame")("align", options::bool_switch(&arguments.align),
                        "find the transform out by what both have seen, and print it");
  options::positional_options_description positions;
  positions.add("a", 1).add("b", 1).add("out", 1);
  if (!tools::parseOptions(argc, argv, description, positions)) return std::nullopt;
  const std::size_t count = arguments.transform.size();
  if (count != 0 && count != 7) {
    throw options::error("--transform has " + std::to_string(count) +
                         " numbers, expected 7: X Y Z QX QY QZ QW");
  }
  if (arguments.align && count != 0) {
    throw options::error("--transform and --align, expected one of them");
  }
  return arguments;
}

Pose toPose(const std::vector<double>& numbers) {
  Pose pose = Pose::Identity();
  if (numbers.empty()) return pose;
  const Eigen::Quaterniond q(numbers[6], numbers[3], numbers[4], numbers[5]);
  if (!(q.norm() > 1e-6) || !q.coeffs().allFinite()) {
    throw options::error("--transform has a quaternion without a direction");
  }
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  return pose;
}

Pose findTransform(const map::Map& a, const map::Map& b) {
  const loops::MapAlignment found = loops::alignMaps(a, b);
  std::cout << loops::toText(found) << std::endl;
  return found.T_a_b;
}

std::shared_ptr<const mapping::OccupancyMap> mergeOccupancy(const Arguments& arguments,
                                                            const Pose& T_a_b) {
  const auto read = [](const std::string& folder) {
    return map::readOccupancy(
        folder, map::readSettings<mapping::OccupancyConfig>(folder, "mesh_fusion", "occupancy"));
  };
  const auto a = read(arguments.a);
  const auto b = read(arguments.b);
  if (a == nullptr || b == nullptr) return a;
  a->addUnknown(*b, T_a_b);
  return a;
}

void run(const Arguments& arguments) {
  const map::Map a = tools::loadMap(arguments.a);
  const map::Map b = tools::loadMap(arguments.b);
  map::MergeOptions how;
  how.T_a_b = arguments.align ? findTransform(a, b) : toPose(arguments.transform);
  how.is_transform_given = arguments.align || !arguments.transform.empty();
  how.places = map::readSettings<places::PlacesConfig>(arguments.a, "mesh_fusion", "places");
  how.name_b = arguments.b;
  map::Map merged = map::mergeMaps(a, b, how);
  merged.setOccupancy(mergeOccupancy(arguments, how.T_a_b));
  const auto files = map::writeMap(arguments.output, merged);
  std::cout << formatCount(a.primitives().size(), "primitive") << " and " << b.primitives().size()
            << " of '" << arguments.b << "' (ids "
            << merged.sources().back().primitive_id_offset + 1 << " to "
            << merged.sources().back().max_primitive_id << ")\n"
            << describeWritten(arguments.output, files) << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("merge_maps", argc, argv, parseArguments, run);
}
