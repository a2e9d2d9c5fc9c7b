// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "task_scene_graph/planning/path.h"
#include "task_scene_graph/scene_graph/scene_graph.h"

namespace tsg::planning {

/// Where a path to something of the scene graph leads. All throw std::invalid_argument naming what
/// there is instead if the id or the name is not there. O(what is looked through).
Goal findPlaceGoal(const PlaceGraph& places, PlaceId id);
/// Before the object's oriented box, or its axis-aligned one if that is empty.
Goal findObjectGoal(const scene_graph::SceneGraph& graph, ObjectId id);
/// The region's most central place.
Goal findRegionGoal(const scene_graph::SceneGraph& graph, RegionId id);

/// The object that serves a task best, or the region; of several, the first.
ObjectId findObject(const scene_graph::SceneGraph& graph, const std::string& task);
RegionId findRegion(const scene_graph::SceneGraph& graph, const std::string& task);

}  // namespace tsg::planning
