// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/core/rotated_box.h"

namespace tsg::evaluation {

/// Which of two boxes contain the other's centre [Clio24, Sec. V-A].
struct Agreement {
  bool is_strict = false;   ///< both
  bool is_relaxed = false;  ///< at least one
};

inline Agreement compareBoxes(const RotatedBox& a, const RotatedBox& b) {
  const bool holds = a.contains(b.center_m);
  const bool is_held = b.contains(a.center_m);
  return {holds && is_held, holds || is_held};
}

}  // namespace tsg::evaluation
