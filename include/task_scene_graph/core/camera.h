// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace tsg {

/// Pinhole camera of a rectified image. Frame: x right, y down, z forward (optical frame). Pixel
/// centres lie at whole numbers.
struct CameraModel {
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;

  /// Pixel (u, v) at depth `z_m` along the optical axis -> point in the camera frame, metres.
  Eigen::Vector3d unproject(double u_px, double v_px, double z_m) const {
    return {(u_px - cx_px) / fx_px * z_m, (v_px - cy_px) / fy_px * z_m, z_m};
  }

  /// Point in the camera frame with z > 0, metres -> pixel (u, v).
  Eigen::Vector2d project(const Eigen::Vector3d& p_camera) const {
    return {fx_px * p_camera.x() / p_camera.z() + cx_px,
            fy_px * p_camera.y() / p_camera.z() + cy_px};
  }

  /// @throws std::invalid_argument that names the field, its value and what is expected, if a size
  /// or focal length is not positive or any number is not finite.
  void validate() const;
};

bool operator==(const CameraModel& a, const CameraModel& b);
inline bool operator!=(const CameraModel& a, const CameraModel& b) { return !(a == b); }

}  // namespace tsg
