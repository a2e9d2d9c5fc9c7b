// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/tracking/segment_view.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace tsg::tracking {
namespace {

constexpr double kShareOfCutView = 0.5;

/// |cosine| of `direction` and the least extended axis of a covariance.
double computeFrontality(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& direction) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3d spread = solver.eigenvalues();
  // A point or a line has no plane: it is seen as well from anywhere.
  const bool has_plane = spread[1] > 1e-6 * std::max(1.0, spread[2]);
  return has_plane ? std::min(1.0, std::abs(direction.dot(solver.eigenvectors().col(0)))) : 1.0;
}

}  // namespace

SegmentView computeSegmentView(const VoxelSet& voxels, double voxel_size_m,
                               const Eigen::Vector3d& camera_m) {
  const Eigen::Vector3d origin = voxels.box.min().cast<double>();  // keeps squares exact
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const VoxelKey key : voxels.keys) {
    const Eigen::Vector3d p = unpackVoxel(key).cast<double>() - origin;
    sum += p;
    squares += p * p.transpose();
  }
  const auto count = static_cast<double>(voxels.size());
  const Eigen::Vector3d mean = sum / count;
  const Eigen::Vector3d center_m = voxel_size_m * (origin + mean + Eigen::Vector3d::Constant(0.5));
  SegmentView view;
  view.distance_m = (center_m - camera_m).norm();
  if (view.distance_m > 0.0) view.direction = (center_m - camera_m) / view.distance_m;
  view.frontality = computeFrontality(squares / count - mean * mean.transpose(), view.direction);
  return view;
}

void ViewRecorder::add(const Observation& observation, const SegmentView& view, std::size_t pixels,
                       bool is_cut) {
  if (count_ == 0) {
    first_direction_ = view.direction;
    statistics_.min_distance_m = view.distance_m;
  }
  ++count_;
  statistics_.min_distance_m = std::min(statistics_.min_distance_m, view.distance_m);
  statistics_.mean_distance_m +=
      (view.distance_m - statistics_.mean_distance_m) / static_cast<double>(count_);
  const double cosine = std::clamp(first_direction_.dot(view.direction), -1.0, 1.0);
  statistics_.spread_rad = std::max(statistics_.spread_rad, std::acos(cosine));
  const double score = static_cast<double>(pixels) * (is_cut ? kShareOfCutView : 1.0);
  if (score <= best_score_) return;
  best_score_ = score;
  statistics_.best = observation;
  statistics_.best_pixels = static_cast<std::uint32_t>(pixels);
}

std::vector<bool> findCutSegments(const cv::Mat& labels, std::size_t num_segments) {
  std::vector<bool> is_cut(num_segments, false);
  const auto note = [&](int u, int v) {
    const std::size_t label = labels.ptr<std::uint16_t>(v)[u];
    if (label >= 1 && label <= num_segments) is_cut[label - 1] = true;
  };
  for (int u = 0; u < labels.cols; ++u) {
    note(u, 0);
    note(u, labels.rows - 1);
  }
  for (int v = 0; v < labels.rows; ++v) {
    note(0, v);
    note(labels.cols - 1, v);
  }
  return is_cut;
}

}  // namespace tsg::tracking
