// SPDX-License-Identifier: BSD-3-Clause
// Spoils the segmentations of a bag as a network would, and leaves everything else as it is.

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "../command_line.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/simulation/segment_faults.h"

namespace options = boost::program_options;
namespace fs = std::filesystem;
using namespace tsg;
using simulation::SegmentFaultsConfig;

namespace {

struct Arguments {
  std::string input;
  std::string output;
  std::string topic = "/segmentation";
  SegmentFaultsConfig faults;
};

constexpr const char* kUsage =
    "Makes the segmentations recorded in a bag as faulty as a network's, from true ones.\n"
    "usage: degrade_segments --input IN.bag --output OUT.bag [--level LEVEL] [options]\n"
    "options, each instead of the level's own value";

SegmentFaultsConfig makeLevel(const std::string& level) {
  if (level == "none") return {};
  if (level == "clip_like") return SegmentFaultsConfig::makeClipLike();
  if (level == "hard") return SegmentFaultsConfig::makeHard();
  throw options::error("--level is '" + level + "', expected none, clip_like or hard");
}

/// Nothing if only help was asked for.
std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  std::string level = "clip_like";
  std::map<std::string, std::string> given;
  options::options_description description(kUsage);
  description.add_options()("help,h", "print this")(
      "input", tools::pathOption(arguments.input)->required(), "bag with segmentations")(
      "output", tools::pathOption(arguments.output)->required(), "bag to write")(
      "topic", options::value(&arguments.topic), "of the segmentations (/segmentation)")(
      "level", options::value(&level), "none, clip_like or hard (clip_like)");
  for (const config::FieldDoc& row : config::describe<SegmentFaultsConfig>()) {
    std::string option = row.name;
    std::replace(option.begin(), option.end(), '_', '-');
    description.add_options()(
        option.c_str(),
        options::value<std::string>()->notifier(
            [&given, name = row.name](const std::string& text) { given[name] = text; }),
        row.doc.c_str());
  }
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  YAML::Node values(YAML::NodeType::Map);
  for (const auto& [name, text] : given) values[name] = text;
  try {
    arguments.faults = config::load(values, "the faults", makeLevel(level));
  } catch (const config::ConfigError& e) {
    throw options::error(e.what());
  }
  return arguments;
}

std::size_t copy(const Arguments& arguments, const fs::path& output) {
  const simulation::SegmentFaults faults(arguments.faults);
  rosbag::Bag from(arguments.input, rosbag::bagmode::Read);
  rosbag::Bag to(output.string(), rosbag::bagmode::Write);
  std::size_t count = 0;
  for (const rosbag::MessageInstance& message : rosbag::View(from)) {
    const auto segmentation = message.getTopic() == arguments.topic
                                  ? message.instantiate<msg::Segmentation>()
                                  : msg::SegmentationConstPtr();
    if (segmentation == nullptr) {
      to.write(message.getTopic(), message.getTime(), message);
      continue;
    }
    const auto clean = ros_interface::fromMessage(segmentation, arguments.topic);
    to.write(message.getTopic(), message.getTime(),
             *ros_interface::toMessage(faults.apply(*clean), segmentation->header.frame_id));
    ++count;
  }
  to.close();
  return count;
}

void run(const Arguments& arguments) {
  std::size_t count = 0;
  replaceFile(arguments.output, [&](const fs::path& temporary) {
    count = copy(arguments, temporary);
    if (count > 0) return;
    throw std::runtime_error("bag '" + arguments.input + "' has no segmentation on topic '" +
                             arguments.topic + "'; name another with --topic");
  });
  std::cout << "[degrade_segments] " << arguments.output << ": "
            << formatCount(count, "segmentation") << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("degrade_segments", argc, argv, parseArguments, run);
}
