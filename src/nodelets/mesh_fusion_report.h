// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/pipeline/background_fusion.h"
#include "task_scene_graph/pipeline/object_fusion.h"
#include "task_scene_graph/ros/stage_report.h"

namespace tsg::nodelets {

/// Lines of the diagnostics on depth integration and archiving.
void reportBackground(const pipeline::BackgroundFusion& background,
                      ros_interface::StageReport& report);

/// Lines of the diagnostics on tracks and objects.
void reportObjects(const pipeline::ObjectFusion& objects, ros_interface::StageReport& report);

}  // namespace tsg::nodelets
