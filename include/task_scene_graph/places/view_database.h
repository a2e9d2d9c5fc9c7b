// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/places/places_config.h"

namespace tsg::places {

/// What a view needs to say whether it sees a point: the depth image is kept as the median of each
/// tile of 8 x 8 px (640 x 480: 9.6 kB), the embedding as it is (D = 768: 3 kB).
struct View {
  static constexpr int kTile_px = 8;

  CameraModel camera;
  Pose T_camera_world = Pose::Identity();
  int tiles_per_row = 0;
  std::vector<std::uint16_t> depth_mm;  ///< per tile; 0 = nothing measured
  Embedding embedding;

  /// True if the point lies in front of the camera, inside the image, within `max_range_m`, and at
  /// most `tolerance_m` behind the measured depth (along the optical axis). Where nothing was
  /// measured nothing hides it.
  bool sees(const Eigen::Vector3d& p_world, double max_range_m, double tolerance_m) const;
};

/// Precondition: depth and camera agree, depth is 16UC1 or 32FC1.
View makeView(const RgbdFrame& frame, const Embedding& embedding);

/// What a view counts for a point at a distance from its camera: 1, or 1 / max(d, 0.5 m)^2.
double computeViewWeight(double distance_m, ViewWeighting weighting);

/// Weighted sum of the embeddings of views that see a point. In single precision: with the count it
/// is all that a place keeps.
struct ViewSum {
  Embedding sum;  ///< empty while count is 0
  double weight = 0.0;
  std::uint32_t count = 0;
  double nearest_m = 0.0;  ///< of all views so far; 0 while count is 0

  /// kClosest: a view takes the place of the others if it is strictly nearer.
  void add(const Embedding& embedding, double distance_m, ViewWeighting weighting);
  Embedding computeMean() const;
};

/// The latest views, at most `max_views` of them.
class ViewDatabase {
 public:
  ViewDatabase(int max_views, double max_range_m, double tolerance_m,
               ViewWeighting weighting = ViewWeighting::kAverage)
      : max_views_(static_cast<std::size_t>(max_views)),
        max_range_m_(max_range_m),
        tolerance_m_(tolerance_m),
        weighting_(weighting) {}

  /// @returns the view taken in, valid until the next call. Forgets the oldest one if full.
  const View& add(View view);
  bool sees(const View& view, const Eigen::Vector3d& p_world) const {
    return view.sees(p_world, max_range_m_, tolerance_m_);
  }
  /// Adds the view to the sum of a point if it sees it. Returns whether it does.
  bool addTo(ViewSum& sum, const View& view, const Eigen::Vector3d& p_world) const;
  /// All remembered views that see a point. O(views).
  ViewSum collect(const Eigen::Vector3d& p_world) const;

  const std::deque<View>& views() const { return views_; }  ///< from the oldest on
  std::size_t size() const { return views_.size(); }
  std::uint64_t numForgotten() const { return forgotten_; }

 private:
  std::size_t max_views_;
  double max_range_m_;
  double tolerance_m_;
  ViewWeighting weighting_;
  std::deque<View> views_;
  std::uint64_t forgotten_ = 0;
};

}  // namespace tsg::places
