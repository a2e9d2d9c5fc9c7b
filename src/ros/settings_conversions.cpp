// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/settings_conversions.h"

namespace tsg::ros_interface {

msg::StageSettings toMessage(const config::StageSettings& settings) {
  msg::StageSettings message;
  message.stage = settings.stage;
  for (const auto& setting : settings.settings) {
    msg::Setting entry;
    entry.name = setting.name;
    entry.value = setting.value;
    entry.origin = setting.origin;
    message.settings.push_back(entry);
  }
  return message;
}

config::StageSettings fromMessage(const msg::StageSettings& message) {
  config::StageSettings settings{message.stage, {}};
  for (const auto& entry : message.settings) {
    settings.settings.push_back({entry.name, entry.value, entry.origin});
  }
  return settings;
}

}  // namespace tsg::ros_interface
