// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <unordered_map>
#include <vector>

#include "task_scene_graph/core/mesh.h"
#include "task_scene_graph/mapping/tsdf_volume.h"
#include "task_scene_graph/trajectory/correction.h"

namespace tsg::trajectory {

/// How far what hangs on keyframes by its position alone reaches.
struct DeformationConfig {
  int num_keyframes = 4;
  double cell_m = 1.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("num_keyframes", self.num_keyframes, {1.0, 100.0}, "",
            "what has no stamp moves with so many keyframes, those nearest to it");
    v.field("cell_m", self.cell_m, {0.05, 100.0}, "m",
            "vertices move as the corners of cells of this size, blended");
  }
};

/// The motion of what is known to lie at a position, but not when it was seen: blended from the
/// nearest keyframes as embedded deformation weighs its nodes [EmbDef07]: (1 - d / d_max)^2
/// with d_max the distance of the first that is left out; continuous in the position. Not
/// thread-safe: what was computed is kept.
class Deformation {
 public:
  /// @param before  where keyframes were; copied
  /// @throws std::invalid_argument if there is no keyframe or one that the correction does not
  /// name; config::ConfigError.
  Deformation(const Keyframes& before, const Correction& correction,
              const DeformationConfig& config = {});

  /// O(keyframes^(1/2)) for a way over a floor.
  Pose motionAt(const Eigen::Vector3d& p_m) const;

  /// The vertices, each moved by the blend of its cell's corners, by distance along each axis. A
  /// vertex that does not move keeps its bits. @returns whether any vertex has moved. O(vertices).
  bool moveVertices(Mesh& mesh);

 private:
  struct Cell {
    std::array<Pose, 8> corners;  ///< x fastest
    bool are_alike = false;
    bool is_still = false;
  };

  const Pose& cornerAt(const mapping::GridIndex& corner);
  const Cell& cellAt(const mapping::GridIndex& index);
  Pose blendCorners(const Cell& cell, const Eigen::Vector3d& share) const;

  DeformationConfig config_;
  std::vector<std::pair<Eigen::Vector3d, Pose>> nodes_;  ///< ascending by x
  bool is_rigid_ = false;
  std::unordered_map<mapping::GridIndex, Pose, mapping::GridIndexHash> corners_;
  std::unordered_map<mapping::GridIndex, Cell, mapping::GridIndexHash> cells_;
};

}  // namespace tsg::trajectory
