// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <task_scene_graph/Ask.h>
#include <task_scene_graph/ChangeTasks.h>
#include <task_scene_graph/EmbedImage.h>
#include <task_scene_graph/Explain.h>
#include <task_scene_graph/Flush.h>
#include <task_scene_graph/GraspPixel.h>
#include <task_scene_graph/Mesh.h>
#include <task_scene_graph/MeshUpdate.h>
#include <task_scene_graph/ObjectPrimitives.h>
#include <task_scene_graph/Octomap.h>
#include <task_scene_graph/OctomapChanges.h>
#include <task_scene_graph/PlaceGraph.h>
#include <task_scene_graph/SaveMesh.h>
#include <task_scene_graph/SceneGraph.h>
#include <task_scene_graph/SceneGraphChanges.h>
#include <task_scene_graph/Segmentation.h>
#include <task_scene_graph/StageSettings.h>
#include <task_scene_graph/TasksInForce.h>
#include <task_scene_graph/Tracks.h>

/// The generators put messages into a namespace named after the package; the library's own code is
/// in `tsg`, where core types have the same names.
namespace tsg {
namespace msg = ::task_scene_graph;
}  // namespace tsg
