// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/core/mesh.h"
#include "task_scene_graph/simulation/apartment.h"

namespace tsg::simulation {

/// The surfaces of all solids of a world, world frame, all grey: boxes exactly,
/// round bodies as polyhedra whose corners lie on them (24 sides: at most 1 % of the radius
/// inside). O(solids).
Mesh computeMesh(const Apartment& world);

}  // namespace tsg::simulation
