// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/input_config.h"

#include <sstream>
#include <vector>

#include "task_scene_graph/config/config.h"

namespace tsg::ros_interface {
namespace {

// Cameras' units lie between 0.01 mm and 1 m.
constexpr double kLeastMetresPerUnit = 1e-5;

std::string format(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

}  // namespace

void checkInput(const InputConfig& config) {
  std::vector<std::string> violations;
  if (!config.pose_topic.empty() && !config.trajectory.empty()) {
    violations.push_back("'pose_topic' is '" + config.pose_topic + "' and 'trajectory' is '" +
                         config.trajectory.string() + "', expected one of them");
  }
  const double metres = toMetresPerUnit(config.depth_scale);
  if (metres != 0.0 && metres < kLeastMetresPerUnit) {
    violations.push_back("'depth_scale' is " + format(config.depth_scale) +
                         ", expected metres for one unit in [1e-05, 1], or units for one metre in "
                         "[1, 100000]");
  }
  for (const auto& [name, value] : {std::pair{"world_frame", config.world_frame},
                                    {"color_topic", config.color_topic},
                                    {"depth_topic", config.depth_topic}}) {
    if (value.empty()) violations.push_back(std::string("'") + name + "' is empty");
  }
  if (config.camera_info_topic.empty() && config.intrinsics.isEmpty()) {
    violations.emplace_back("'camera_info_topic' is empty, expected it or 'intrinsics'");
  }
  config::internal::throwIfAny("input", violations);
}

double toMetresPerUnit(double depth_scale) {
  return depth_scale > 1.0 ? 1.0 / depth_scale : depth_scale;
}

}  // namespace tsg::ros_interface
