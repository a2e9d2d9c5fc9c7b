// SPDX-License-Identifier: BSD-3-Clause
#include "synthetic_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tsg::test {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

double hitSphere(const Eigen::Vector3d& from_center, const Eigen::Vector3d& direction, double r) {
  const double a = direction.squaredNorm();
  const double b = from_center.dot(direction);
  const double discriminant = b * b - a * (from_center.squaredNorm() - r * r);
  if (discriminant < 0.0) return kNever;
  const double t = (-b - std::sqrt(discriminant)) / a;
  return t > 0.0 ? t : kNever;
}

double hitBox(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& origin,
              const Eigen::Vector3d& direction) {
  const Eigen::Array3d to_min = (box.min() - origin).array() / direction.array();
  const Eigen::Array3d to_max = (box.max() - origin).array() / direction.array();
  const double enter = to_min.min(to_max).maxCoeff();
  const double leave = to_min.max(to_max).minCoeff();
  return enter > 0.0 && enter <= leave ? enter : kNever;
}

double distanceToBox(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& p) {
  const Eigen::Vector3d q = (p - box.center()).cwiseAbs() - 0.5 * box.sizes();
  return q.cwiseMax(0.0).norm() + std::min(0.0, q.maxCoeff());
}

}  // namespace

Solid makePlane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, cv::Vec3b color_rgb) {
  Solid solid;
  solid.hit = [=](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const double t = normal.dot(point - origin) / normal.dot(direction);
    return t > 0.0 ? t : kNever;
  };
  solid.distance_m = [=](const Eigen::Vector3d& p) { return normal.dot(p - point); };
  solid.color_rgb = color_rgb;
  return solid;
}

Solid makeSphere(const Eigen::Vector3d& center, double radius_m, cv::Vec3b color_rgb,
                 std::uint16_t label) {
  Solid solid;
  solid.hit = [=](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    return hitSphere(origin - center, direction, radius_m);
  };
  solid.distance_m = [=](const Eigen::Vector3d& p) { return (p - center).norm() - radius_m; };
  solid.color_rgb = color_rgb;
  solid.label = label;
  return solid;
}

Solid makeBox(const Eigen::AlignedBox3d& box, cv::Vec3b color_rgb, std::uint16_t label) {
  Solid solid;
  solid.hit = [=](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    return hitBox(box, origin, direction);
  };
  solid.distance_m = [=](const Eigen::Vector3d& p) { return distanceToBox(box, p); };
  solid.color_rgb = color_rgb;
  solid.label = label;
  return solid;
}

Rendering render(const std::vector<Solid>& scene, const CameraModel& camera,
                 const Pose& T_world_camera) {
  Rendering out;
  out.frame.camera = camera;
  out.frame.T_world_camera = T_world_camera;
  out.frame.color.image = cv::Mat::zeros(camera.height_px, camera.width_px, CV_8UC3);
  out.frame.depth.image = cv::Mat::zeros(camera.height_px, camera.width_px, CV_32FC1);
  out.frame.depth.metres_per_unit = 1.0;
  out.labels = cv::Mat::zeros(camera.height_px, camera.width_px, CV_16UC1);
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      // z = 1 along the optical axis, so that t is the depth.
      const Eigen::Vector3d direction = T_world_camera.linear() * camera.unproject(u, v, 1.0);
      double nearest = kNever;
      for (const auto& solid : scene) {
        const double t = solid.hit(T_world_camera.translation(), direction);
        if (!(t < nearest)) continue;
        nearest = t;
        out.frame.color.image.at<cv::Vec3b>(v, u) = solid.color_rgb;
        out.labels.at<std::uint16_t>(v, u) = solid.label;
      }
      if (nearest < kNever) out.frame.depth.image.at<float>(v, u) = static_cast<float>(nearest);
    }
  }
  return out;
}

Pose lookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ());
  if (right.norm() < 1e-6) right = Eigen::Vector3d::UnitX();
  right.normalize();
  Pose pose = Pose::Identity();
  pose.linear().col(0) = right;
  pose.linear().col(1) = forward.cross(right);
  pose.linear().col(2) = forward;
  pose.translation() = eye;
  return pose;
}

double computeSceneDistance(const std::vector<Solid>& scene, const Eigen::Vector3d& p) {
  double nearest = kNever;
  for (const auto& solid : scene) nearest = std::min(nearest, solid.distance_m(p));
  return nearest;
}

}  // namespace tsg::test
