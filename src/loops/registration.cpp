// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/registration.h"

#include <pcl/console/print.h>
#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/correspondence_estimation.h>
#include <pcl/registration/correspondence_rejection_sample_consensus.h>
#include <pcl/registration/icp.h>
#include <pcl/search/kdtree.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "task_scene_graph/config/config.h"

namespace tsg::loops {
namespace {

using Cloud = pcl::PointCloud<pcl::PointNormal>;
using Features = pcl::PointCloud<pcl::FPFHSignature33>;
using Tree = pcl::search::KdTree<pcl::PointNormal>;

constexpr std::size_t kLeastPoints = 50;
constexpr double kLeastCosine = 0.7;
constexpr double kLeastStart = 0.1;  ///< share of points that have another to be drawn to
constexpr int kRansacIterations = 5000;
constexpr std::size_t kLeastFeatures = 10;
/// Farthest pair of points, as multiples of inlier_m, and iterations with it.
constexpr std::pair<double, int> kLevels[] = {{8.0, 15}, {4.0, 15}, {2.0, 20}};

Cloud::Ptr toCloud(const Points& points) {
  Cloud::Ptr cloud(new Cloud);
  for (const Eigen::Vector3f& p : points) {
    pcl::PointNormal point;
    point.getVector3fMap() = p;
    cloud->push_back(point);
  }
  return cloud;
}

Eigen::Vector3d positionOf(const pcl::PointNormal& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

Eigen::Vector3d normalOf(const pcl::PointNormal& p) {
  return {static_cast<double>(p.normal_x), static_cast<double>(p.normal_y),
          static_cast<double>(p.normal_z)};
}

bool hasNormal(const pcl::PointNormal& point) { return std::isfinite(point.normal_x); }

/// Normals face the origin. Points without one (too few neighbours) are left out.
Cloud::Ptr withNormals(const Points& points, double radius_m) {
  const Cloud::Ptr cloud = toCloud(points);
  if (cloud->empty()) return cloud;
  pcl::NormalEstimation<pcl::PointNormal, pcl::PointNormal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(Tree::Ptr(new Tree));
  estimation.setRadiusSearch(radius_m);
  estimation.setViewPoint(0.0F, 0.0F, 0.0F);
  Cloud normals;
  estimation.compute(normals);
  Cloud::Ptr result(new Cloud);
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    pcl::PointNormal point = normals.points[i];
    point.getVector3fMap() = cloud->points[i].getVector3fMap();
    if (hasNormal(point)) result->push_back(point);
  }
  return result;
}

Features::Ptr computeFeatures(const Cloud::Ptr& cloud, double radius_m) {
  Features::Ptr features(new Features);
  if (cloud->empty()) return features;
  pcl::FPFHEstimation<pcl::PointNormal, pcl::PointNormal, pcl::FPFHSignature33> estimation;
  estimation.setInputCloud(cloud);
  estimation.setInputNormals(cloud);
  estimation.setSearchMethod(Tree::Ptr(new Tree));
  estimation.setRadiusSearch(radius_m);
  estimation.compute(*features);
  return features;
}

Pose toPose(const Eigen::Matrix4f& matrix) {
  Pose pose = Pose::Identity();
  pose.linear() =
      Eigen::Quaterniond(matrix.topLeftCorner<3, 3>().cast<double>()).normalized().matrix();
  pose.translation() = matrix.topRightCorner<3, 1>().cast<double>();
  return pose;
}

}  // namespace

struct RegisteredCloud::Data {
  Cloud::Ptr points;
  Tree::Ptr tree;
  Cloud::Ptr key_points;
  Features::Ptr features;
};

RegisteredCloud::RegisteredCloud(const Points& points, const RegistrationConfig& config) {
  config::validate(config, "registration");
  auto data = std::make_shared<Data>();
  data->points =
      withNormals(downsample(points, static_cast<float>(config.voxel_m)), config.normal_radius_m);
  data->tree.reset(new Tree);
  if (!data->points->empty()) data->tree->setInputCloud(data->points);
  data->key_points = withNormals(downsample(points, static_cast<float>(config.feature_voxel_m)),
                                 2.0 * config.normal_radius_m);
  data->features = computeFeatures(data->key_points, config.feature_radius_m);
  data_ = std::move(data);
}

std::size_t RegisteredCloud::size() const { return data_->points->size(); }

bool alignByFeatures(const RegisteredCloud& source, const RegisteredCloud& target,
                     const RegistrationConfig& config, Pose& T_target_source) {
  T_target_source = Pose::Identity();
  const auto& from = source.data();
  const auto& to = target.data();
  if (std::min(from.features->size(), to.features->size()) < kLeastPoints) return false;
  pcl::registration::CorrespondenceEstimation<pcl::FPFHSignature33, pcl::FPFHSignature33> matcher;
  matcher.setInputSource(from.features);
  matcher.setInputTarget(to.features);
  pcl::CorrespondencesPtr matches(new pcl::Correspondences);
  matcher.determineReciprocalCorrespondences(*matches);
  if (matches->size() < kLeastFeatures) return false;
  pcl::registration::CorrespondenceRejectorSampleConsensus<pcl::PointNormal> ransac;
  ransac.setInputSource(from.key_points);
  ransac.setInputTarget(to.key_points);
  ransac.setInlierThreshold(1.5 * config.feature_voxel_m);
  ransac.setMaximumIterations(kRansacIterations);
  ransac.setInputCorrespondences(matches);
  pcl::Correspondences inliers;
  ransac.getCorrespondences(inliers);
  // Without a model PCL gives back all matches and the identity.
  if (inliers.size() < kLeastFeatures || inliers.size() == matches->size()) return false;
  T_target_source = toPose(ransac.getBestTransformation());
  return true;
}

namespace {

/// What points of one cloud find in the other.
struct Fit {
  double share = 0.0;
  double rms_m = 0.0;
  trajectory::Matrix6d fixation = trajectory::Matrix6d::Zero();
};

Fit computeFit(const Cloud& source, const RegisteredCloud::Data& target,
               const Pose& T_target_source, double inlier_m) {
  trajectory::Matrix6d sum = trajectory::Matrix6d::Zero();
  double squares = 0.0;
  double count = 0.0;
  std::vector<int> index(1);
  std::vector<float> squared_m2(1);
  for (const pcl::PointNormal& point : source.points) {
    const Eigen::Vector3d p = positionOf(point);
    const Eigen::Vector3d moved = T_target_source * p;
    pcl::PointNormal query;
    query.x = static_cast<float>(moved.x());
    query.y = static_cast<float>(moved.y());
    query.z = static_cast<float>(moved.z());
    if (target.tree->nearestKSearch(query, 1, index, squared_m2) != 1) continue;
    const pcl::PointNormal& other = target.points->points[static_cast<std::size_t>(index[0])];
    const Eigen::Vector3d n = T_target_source.linear().transpose() * normalOf(other);
    if (static_cast<double>(squared_m2[0]) > inlier_m * inlier_m) continue;
    if (normalOf(point).dot(n) < kLeastCosine) continue;
    trajectory::Vector6d J;
    J << n, p.cross(n) / kLever_m;
    sum += J * J.transpose();
    squares += std::pow(normalOf(other).dot(moved - positionOf(other)), 2);
    count += 1.0;
  }
  if (count == 0.0) return {};
  return {count / static_cast<double>(source.size()), std::sqrt(squares / count), sum / count};
}

/// PCL prints where it finds nothing; that is an answer here. Its level is the process's.
class Quiet {
 public:
  Quiet() : level_(pcl::console::getVerbosityLevel()) {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  }
  ~Quiet() { pcl::console::setVerbosityLevel(level_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  pcl::console::VERBOSITY_LEVEL level_;
};

Pose refine(const Cloud::Ptr& source, const RegisteredCloud::Data& target, Pose T_target_source,
            double inlier_m) {
  for (const auto& [reach, num_iterations] : kLevels) {
    const Fit fit = computeFit(*source, target, T_target_source, reach * inlier_m);
    if (fit.share < kLeastStart) return T_target_source;
    pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp;
    icp.setInputSource(source);
    icp.setInputTarget(target.points);
    icp.setSearchMethodTarget(target.tree, true);
    icp.setMaxCorrespondenceDistance(reach * inlier_m);
    icp.setMaximumIterations(num_iterations);
    icp.setTransformationEpsilon(1e-8);
    Cloud aligned;
    icp.align(aligned, T_target_source.matrix().cast<float>());
    const Eigen::Matrix4f result = icp.getFinalTransformation();
    if (!result.allFinite()) return T_target_source;
    T_target_source = toPose(result);
  }
  return T_target_source;
}

}  // namespace

Registration registerClouds(const RegisteredCloud& source, const RegisteredCloud& target,
                            const std::vector<Pose>& guesses, const RegistrationConfig& config) {
  Registration best;
  if (std::min(source.size(), target.size()) < kLeastPoints) return best;
  const Quiet quiet;
  for (const Pose& guess : guesses) {
    const Pose T = refine(source.data().points, target.data(), guess, config.inlier_m);
    const Fit there = computeFit(*source.data().points, target.data(), T, config.inlier_m);
    const Fit back = computeFit(*target.data().points, source.data(), T.inverse(), config.inlier_m);
    const double overlap = std::min(there.share, back.share);
    if (overlap > best.overlap) best = {T, overlap, there.rms_m, there.fixation};
  }
  best.least_eigenvalue =
      Eigen::SelfAdjointEigenSolver<trajectory::Matrix6d>(best.fixation, Eigen::EigenvaluesOnly)
          .eigenvalues()(0);
  return best;
}

}  // namespace tsg::loops
