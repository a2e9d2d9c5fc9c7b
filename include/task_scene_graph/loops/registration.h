// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/loops/local_cloud.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::loops {

struct RegistrationConfig {
  double voxel_m = 0.1;
  double normal_radius_m = 0.25;
  double feature_voxel_m = 0.2;
  double feature_radius_m = 0.6;
  double inlier_m = 0.1;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("voxel_m", self.voxel_m, {0.01, 1.0}, "m", "points of a cloud are so far apart");
    v.field("normal_radius_m", self.normal_radius_m, {0.02, 2.0}, "m",
            "points around one that its normal is made of");
    v.field("feature_voxel_m", self.feature_voxel_m, {0.02, 2.0}, "m",
            "... of points that get a feature (FPFH)");
    v.field("feature_radius_m", self.feature_radius_m, {0.05, 5.0}, "m",
            "points around one that its feature is made of");
    v.field("inlier_m", self.inlier_m, {0.01, 1.0}, "m",
            "a point fits if the nearest one of the other cloud is so near and faces the same way");
  }
};

/// A cloud with normals, features and a tree, made once for all registrations. Points lie around
/// the origin, from which they were seen. Immutable; copying it copies a pointer. Not thread-safe:
/// PCL's searches are not.
class RegisteredCloud {
 public:
  /// O(points log points). @throws config::ConfigError
  RegisteredCloud(const Points& points, const RegistrationConfig& config);

  std::size_t size() const;
  struct Data;
  const Data& data() const { return *data_; }

 private:
  std::shared_ptr<const Data> data_;
};

constexpr double kLever_m = 2.0;  ///< an angle counts as the motion of a point so far away

/// How well one cloud lies on another.
struct Registration {
  Pose T_target_source = Pose::Identity();
  double overlap = 0.0;  ///< share of points that fit: of source or target, the lower
  double rms_m = 0.0;    ///< of those of source that fit, from the target's planes
  /// Mean of J J^T over points that fit, J = [n; (p x n) / kLever_m], n the target's normals, all
  /// in the source's frame: how much they fix a motion (position, then angle) of the source there.
  trajectory::Matrix6d fixation = trajectory::Matrix6d::Zero();
  /// Its least eigenvalue: 1/3 for normals to all sides, 0 where something can slide or turn (a
  /// corridor, a single wall).
  double least_eigenvalue = 0.0;
};

/// A motion from features alone: fast point feature histograms [FPFH09], nearest ones of both
/// clouds that are each other's, RANSAC with seeds of its own (the same from run to run).
/// Identity, and false, where there are too few.
bool alignByFeatures(const RegisteredCloud& source, const RegisteredCloud& target,
                     const RegistrationConfig& config, Pose& T_target_source);

/// Iterated closest points to planes (PCL), from each guess, coarse to fine; that with the largest
/// overlap. No guesses, or clouds of fewer than 50 points: overlap 0. O(guesses * points log
/// points).
Registration registerClouds(const RegisteredCloud& source, const RegisteredCloud& target,
                            const std::vector<Pose>& guesses, const RegistrationConfig& config);

}  // namespace tsg::loops
