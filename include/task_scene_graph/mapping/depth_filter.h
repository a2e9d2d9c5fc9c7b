// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"

namespace tsg::mapping {

/// What is done to depth images before they are fused. (The range is the integrator's min_range_m
/// and max_range_m.)
struct DepthFilterConfig {
  /// tan(88 deg): flatter than that, hardly any camera measures a surface. At 525 px focal length
  /// it is 5.3 % of the depth from pixel to pixel, beyond the noise and the steps of structured
  /// light and stereo at any range in use.
  double max_slope = 28.0;
  bool reject_flying_pixels = true;
  int min_support_px = 2;
  int edge_margin_px = 0;
  int bilateral_radius_px = 0;
  double bilateral_sigma_m = 0.03;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("max_slope", self.max_slope, {0.1, 1e6}, "m/m",
            "neighbouring readings with a steeper step in depth lie on different surfaces");
    v.field("reject_flying_pixels", self.reject_flying_pixels, {}, "",
            "drop readings that hang between the surfaces on their two sides");
    v.field("min_support_px", self.min_support_px, {0, 8}, "px",
            "drop readings with fewer of their 8 neighbours on the same surface; 0 = off");
    v.field("edge_margin_px", self.edge_margin_px, {0, 16}, "px",
            "drop readings so near to a step in depth, on both sides; 0 = off");
    v.field("bilateral_radius_px", self.bilateral_radius_px, {0, 8}, "px",
            "smooth within surfaces over this radius; 0 = off (4 to 5 ms per frame at 2)");
    v.field("bilateral_sigma_m", self.bilateral_sigma_m, {1e-4, 1.0}, "m",
            "readings that differ by much more than this do not smooth each other");
  }

  bool isOff() const {
    return !reject_flying_pixels && min_support_px == 0 && edge_margin_px == 0 &&
           bilateral_radius_px == 0;
  }
};

struct DepthFilterCounters {
  std::size_t valid_readings = 0;     ///< of all frames, before the filter
  std::size_t rejected_readings = 0;  ///< ... of those, dropped
};

/// Drops or smooths doubtful depth readings. With t = z max_slope / min(fx, fy) of a reading z,
/// - a flying pixel has its left and right, or upper and lower, neighbours farther than t from it,
///   one before and one behind (what a sensor reports that mixes two surfaces in one pixel);
/// - a neighbour supports a reading if it differs by at most t;
/// - a step is a valid neighbour to the left, right, above or below that differs by more than t.
/// Thin things (one pixel wide, before something far) stay: nothing lies before them.
/// Not thread-safe (keeps scratch memory).
class DepthFilter {
 public:
  /// @throws config::ConfigError if a value is out of range.
  explicit DepthFilter(const DepthFilterConfig& config);

  const DepthFilterConfig& config() const { return config_; }
  const DepthFilterCounters& counters() const { return counters_; }

  /// The depth image in metres (CV_32FC1, 0 = invalid) after the filter, the very same image if all
  /// is off; the argument's pixels are not touched. Invalid pixels stay invalid. O(pixels).
  /// Precondition: RgbdFrame::validate() holds for an image with this camera.
  DepthImage apply(const DepthImage& depth, const CameraModel& camera);

 private:
  void readPadded(const DepthImage& depth);
  cv::Mat reject(const CameraModel& camera);
  void rejectMargins(const CameraModel& camera, cv::Mat& depth_m) const;
  cv::Mat smooth(const cv::Mat& depth_m) const;

  DepthFilterConfig config_;
  DepthFilterCounters counters_;
  cv::Mat padded_m_;  ///< the image with a rim of one pixel of zeros
};

}  // namespace tsg::mapping
