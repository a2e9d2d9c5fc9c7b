// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "depth_statistics.h"
#include "task_scene_graph/plausibility/finding.h"

namespace tsg::plausibility {

/// A unit in which depth images are written.
struct DepthUnit {
  double metres = 0.001;
  std::string users;  ///< who writes it
};

/// The known units between two lengths, metres; those that differ least from `likely_m`, as a
/// ratio, come first.
std::vector<DepthUnit> findDepthUnits(double low_m, double high_m, double likely_m);

/// "0.0002 (TUM datasets) or 0.00025 (RealSense L515)".
std::string listUnits(const std::vector<DepthUnit>& units);

/// Whether there are readings, and in the range that maps are made of. `metres_per_unit`: of the
/// images.
std::optional<Finding> checkDepthRange(const DepthStatistics& depth, double metres_per_unit,
                                       double min_range_m, double max_range_m);

}  // namespace tsg::plausibility
