// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/settings_follower.h"

#include <ros/names.h>

#include <algorithm>

#include "task_scene_graph/ros/settings_conversions.h"

namespace tsg::ros_interface {

SettingsFollower::SettingsFollower(::ros::NodeHandle handle,
                                   const std::vector<std::string>& stages) {
  for (std::size_t i = 0; i < stages.size(); ++i) {
    stages_.push_back(handle.resolveName(stages[i]));
    const auto receive = [this, i](const msg::StageSettings::ConstPtr& message) {
      const std::lock_guard<std::mutex> lock(mutex_);
      settings_[i] = fromMessage(*message);
    };
    subscribers_.push_back(handle.subscribe<msg::StageSettings>(
        ::ros::names::append(stages[i], "settings"), 1, receive));
  }
}

std::vector<config::StageSettings> SettingsFollower::settings() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<config::StageSettings> settings;
  for (const auto& entry : settings_) settings.push_back(entry.second);
  return settings;
}

bool SettingsFollower::knows(const std::string& stage) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::any_of(settings_.begin(), settings_.end(),
                     [&](const auto& entry) { return stages_[entry.first] == stage; });
}

}  // namespace tsg::ros_interface
