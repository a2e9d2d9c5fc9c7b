// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/simulation/apartment.h"

namespace tsg::simulation {

/// The room behind the open east end of a storey's corridor, in which the stairs are: two flights
/// side by side, with a landing half way up.
Room makeStaircaseRoom(const Apartment& storey);

/// Adds the walls of the staircase, the floors before it and the flights between the floors. The
/// way up goes to `stairs`. @param building  has a staircase room for each of `num_floors` floors
void addStairs(Apartment& building, int num_floors);

}  // namespace tsg::simulation
