// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/tracking/voxel_set.h"

namespace tsg::tracking {

/// From where the camera sees a segment.
struct SegmentView {
  double distance_m = 0.0;  ///< to the centre of its voxels
  Eigen::Vector3d direction =
      Eigen::Vector3d::UnitZ();  ///< unit vector to that centre, world frame
  /// |cosine| of the direction and the normal of the plane that fits the voxels best: 1 = head-on.
  double frontality = 1.0;
};

/// O(voxels). Precondition: the set is not empty.
SegmentView computeSegmentView(const VoxelSet& voxels, double voxel_size_m,
                               const Eigen::Vector3d& camera_m);

/// Statistics of a track's views, one at a time.
class ViewRecorder {
 public:
  /// @param is_cut  the segment touches the border of the image.
  void add(const Observation& observation, const SegmentView& view, std::size_t pixels,
           bool is_cut);

  const ViewStatistics& statistics() const { return statistics_; }

 private:
  ViewStatistics statistics_;
  Eigen::Vector3d first_direction_ = Eigen::Vector3d::UnitZ();
  double best_score_ = 0.0;
  std::size_t count_ = 0;
};

/// For each label 1 .. num_segments whether it touches the border of the image. O(border).
std::vector<bool> findCutSegments(const cv::Mat& labels, std::size_t num_segments);

}  // namespace tsg::tracking
