// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "task_scene_graph/core/stamp.h"

namespace tsg {

/// Whether what was done last at `last` (nothing: never) and is to be done every `period_s` seconds
/// is to be done at `now`: also when stamps have jumped back, as those of a bag in a loop do.
inline bool isDue(const std::optional<Stamp>& last, Stamp now, double period_s) {
  return !last || now < *last || secondsBetween(*last, now) >= period_s;
}

}  // namespace tsg
