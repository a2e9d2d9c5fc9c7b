// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "task_scene_graph/core/camera.h"
#include "task_scene_graph/simulation/solid.h"

namespace tsg::simulation {

/// The solids as one camera sees them: rays start at the origin of the camera frame, so the origin
/// in each solid's unit frame is computed once, and image tiles know which solids they can show.
class ViewSolids {
 public:
  static constexpr int kTile_px = 16;

  struct Hit {
    int index = -1;  ///< of the solid; -1 = nothing hit
    double depth_m = 0.0;
  };

  ViewSolids(const std::vector<Solid>& solids, const CameraModel& camera,
             const Pose& T_world_camera);

  /// Nearest solid along `direction` (camera frame, z = 1, so lengths are depths). `u_px`, `v_px`:
  /// the pixel that the ray passes (between -0.5 and 0.5 px beside its centre). Equal depths go to
  /// the smaller index.
  Hit cast(const Eigen::Vector3d& direction, int u_px, int v_px) const;

  /// Camera frame, metres -> unit frame of a solid.
  Eigen::Vector3d toUnit(int index, const Eigen::Vector3d& p_camera) const {
    const SeenSolid& seen = seen_[static_cast<std::size_t>(index)];
    return seen.origin + seen.unit_from_camera * p_camera;
  }

 private:
  struct SeenSolid {
    Eigen::Matrix3d unit_from_camera;
    Eigen::Vector3d origin;  // of the camera, unit coordinates
    Shape shape = Shape::kBox;
    double top_ratio = 1.0;
    double nearest_m = 0.0;  // no point of the solid has a smaller depth
    cv::Rect pixels;         // outside of it the solid is not seen
  };

  SeenSolid computeSeenSolid(const Solid& solid, const CameraModel& camera,
                             const Pose& T_camera_world) const;
  void fillTiles(const CameraModel& camera);

  int tile_columns_ = 0;
  std::vector<SeenSolid> seen_;
  std::vector<std::vector<int>> tiles_;  // indices by nearest depth
};

}  // namespace tsg::simulation
