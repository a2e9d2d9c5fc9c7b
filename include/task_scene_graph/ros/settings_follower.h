// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "task_scene_graph/config/settings.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::ros_interface {

/// Keeps the newest parameters in force of other stages, out of their latched topics `settings`.
/// Thread-safe.
class SettingsFollower {
 public:
  /// @param stages  node names, resolved by `handle`
  SettingsFollower(::ros::NodeHandle handle, const std::vector<std::string>& stages);

  /// In the order of `stages`; a stage that is not there is left out.
  std::vector<config::StageSettings> settings() const;
  /// Whether a stage is there, or was. @param stage  resolved name
  bool knows(const std::string& stage) const;

 private:
  std::vector<std::string> stages_;  ///< resolved
  mutable std::mutex mutex_;         ///< guards settings_
  std::map<std::size_t, config::StageSettings> settings_;
  std::vector<::ros::Subscriber> subscribers_;
};

}  // namespace tsg::ros_interface
