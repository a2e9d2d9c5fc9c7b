// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "consistency.h"
#include "task_scene_graph/plausibility/finding.h"

namespace tsg::plausibility {

/// What the report's words need besides the verdict.
struct InputFacts {
  double median_depth_m = 0.0;
  double metres_per_unit = 0.001;  ///< of depth images
  CameraModel camera;              ///< of the images
};

/// The lines of the report that follow from a verdict: none if the frames agree as given or nothing
/// can be said, two if two things are wrong at once.
std::vector<Finding> describeVerdict(const Verdict& verdict, const std::vector<ViewGroup>& groups,
                                     const InputFacts& facts);

}  // namespace tsg::plausibility
