// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <vector>

#include "task_scene_graph/core/frame.h"

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

/// Sum of the embeddings of views that see a point.
struct ViewSum {
  Eigen::VectorXd sum;  ///< empty while count is 0
  std::uint32_t count = 0;

  void add(const Embedding& embedding);
  Embedding computeMean() const;
};

/// The latest views, at most `max_views` of them.
class ViewDatabase {
 public:
  ViewDatabase(int max_views, double max_range_m, double tolerance_m)
      : max_views_(static_cast<std::size_t>(max_views)),
        max_range_m_(max_range_m),
        tolerance_m_(tolerance_m) {}

  /// @returns the view taken in, valid until the next call. Forgets the oldest one if full.
  const View& add(View view);
  bool sees(const View& view, const Eigen::Vector3d& p_world) const {
    return view.sees(p_world, max_range_m_, tolerance_m_);
  }
  /// All remembered views that see a point. O(views).
  ViewSum collect(const Eigen::Vector3d& p_world) const;

  std::size_t size() const { return views_.size(); }
  std::uint64_t numForgotten() const { return forgotten_; }

 private:
  std::size_t max_views_;
  double max_range_m_;
  double tolerance_m_;
  std::deque<View> views_;
  std::uint64_t forgotten_ = 0;
};

}  // namespace tsg::places
