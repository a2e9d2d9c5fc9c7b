// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "task_scene_graph/core/camera.h"

namespace tsg::simulation {

/// How an active stereo camera sees depth.
struct DepthNoiseConfig {
  double min_range_m = 0.3;
  double max_range_m = 6.0;
  double axial_m = 0.001;
  double axial_per_m = 0.0019;
  double baseline_m = 0.095;
  double subpixel_px = 0.05;
  double edge_dropout = 0.5;
  double grazing_cosine = 0.2;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("min_range_m", self.min_range_m, {0.0, 10.0}, "m", "nothing nearer is measured");
    v.field("max_range_m", self.max_range_m, {0.1, 65.0}, "m", "nothing farther is measured");
    v.field("axial_m", self.axial_m, {0.0, 1.0}, "m", "standard deviation at 0 m");
    v.field("axial_per_m", self.axial_per_m, {0.0, 1.0}, "1/m",
            "growth of the standard deviation with the square of the depth");
    v.field("baseline_m", self.baseline_m, {0.001, 10.0}, "m", "between the two imagers");
    v.field("subpixel_px", self.subpixel_px, {0.0, 1.0}, "px",
            "step of the disparity; 0 = no quantisation");
    v.field("edge_dropout", self.edge_dropout, {0.0, 1.0}, "",
            "share of pixels at depth edges that are not measured");
    v.field("grazing_cosine", self.grazing_cosine, {0.0, 1.0}, "",
            "surfaces whose normal has a smaller cosine to the ray drop out more and more");
  }
};

/// Depth in millimetres (CV_16UC1, 0 = not measured) as such a camera would give it:
///   z' = quantise(z + N(0, axial_m + axial_per_m z^2)), disparity steps of subpixel_px,
/// with dropouts at depth edges, at grazing surfaces and out of range. `depth_m`: CV_32FC1, exact.
/// The noise of a pixel follows from (seed, frame, pixel) alone. Results do not depend on
/// `num_threads`. @throws config::ConfigError; std::invalid_argument for another image type.
cv::Mat simulateDepthSensor(const cv::Mat& depth_m, const CameraModel& camera,
                            const DepthNoiseConfig& config, std::uint64_t seed, std::int64_t frame,
                            int num_threads);

/// Exact depth in millimetres, rounded, CV_16UC1; 0 out of the range.
cv::Mat toMillimetres(const cv::Mat& depth_m, double min_range_m, double max_range_m);

}  // namespace tsg::simulation
