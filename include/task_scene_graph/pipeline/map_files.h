// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/map/files.h"

/// Former names of what is in map/files.h, for stages that do not hold a map::Map yet.
namespace tsg::pipeline {

using map::writeGraphFiles;
using map::writeMeshFile;
using map::writeOccupancyFiles;
using map::writeSettingsFile;

}  // namespace tsg::pipeline
