// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "node_mesh.h"
#include "task_scene_graph/core/box.h"
#include "task_scene_graph/core/rotated_box.h"

namespace tsg::scene_graph {

/// Hull of a node's box in the world, empty if the box is INVALID.
///
/// From 1.0.3 on, boxes have a centre and `dimensions`. Before, they had corners `min` and `max`:
/// in the world for axis-aligned boxes, in the box's own axes around the centre for others.
/// @throws std::runtime_error saying what is wrong with `bounding_box`.
Aabb readBox(const nlohmann::json& attributes);

/// A node's box as it is turned, not checked to be finite; without size if the box is INVALID.
/// @throws std::runtime_error saying what is wrong with `bounding_box`.
RotatedBox readRotatedBox(const nlohmann::json& attributes);

/// The box of least footprint that this package notes in `metadata`; nothing without one.
/// @throws std::runtime_error saying what is wrong with it.
std::optional<OrientedBox> readNotedBox(const nlohmann::json& attributes);

/// As `metadata` notes a box.
nlohmann::json toNotedBox(const OrientedBox& box);

/// How a node's mesh lies in the world: relative to its box's centre and axes; to the lower corner
/// of a box by world corners.
/// @throws std::runtime_error saying what is wrong with `bounding_box`.
MeshFrame readMeshFrame(const nlohmann::json& attributes);

/// A box of the world's axes in the form of another one, which can be read; that one itself for an
/// empty hull.
nlohmann::json replaceBox(const nlohmann::json& form, const Aabb& hull);

}  // namespace tsg::scene_graph
