// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/config/settings.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::ros_interface {

msg::StageSettings toMessage(const config::StageSettings& settings);
config::StageSettings fromMessage(const msg::StageSettings& message);

}  // namespace tsg::ros_interface
