// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <unordered_map>
#include <vector>

#include "task_scene_graph/core/mesh.h"
#include "task_scene_graph/mapping/tsdf_volume.h"
#include "task_scene_graph/trajectory/correction.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::trajectory {

/// How far what hangs on keyframes by its position alone reaches.
struct DeformationConfig {
  int num_keyframes = 4;
  double cell_m = 1.0;
  int num_threads = 2;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("num_keyframes", self.num_keyframes, {1.0, 100.0}, "",
            "what has no stamp moves with so many keyframes, those nearest to it");
    v.field("cell_m", self.cell_m, {0.05, 100.0}, "m",
            "vertices move as the corners of cells of this size, blended");
    v.field("num_threads", self.num_threads, {1, 256}, "", "threads that move meshes");
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

  /// Computes what move() needs for a mesh. O(vertices) where it is spread over many cells.
  void prepare(const Mesh& mesh);
  /// False if no vertex of a mesh that is prepared moves. As prepare().
  bool moves(const Mesh& mesh) const;
  /// The vertices of a mesh that is prepared, each moved by the blend of its cell's corners, by
  /// distance along each axis. A vertex that does not move keeps its bits. @returns whether any
  /// vertex has moved. O(vertices). From any number of threads.
  bool move(Mesh& mesh) const;

  /// prepare() and move().
  bool moveVertices(Mesh& mesh);

 private:
  struct Cell {
    std::array<DualQuaternion, 8> corners;  ///< x fastest; on one side of the double cover
    Pose motion = Pose::Identity();         ///< of the first corner
    bool are_alike = false;                 ///< all move as the first
    bool is_still = false;
  };
  using Cells = std::unordered_map<mapping::GridIndex, Cell, mapping::GridIndexHash>;

  mapping::GridIndex cellOf(const Eigen::Vector3d& p_m) const;
  std::vector<mapping::GridIndex> findCells(const Mesh& mesh) const;
  const Pose& cornerAt(const mapping::GridIndex& corner);
  void addCell(const mapping::GridIndex& index);
  /// Where a point of a cell comes to lie. @param share  along each axis, from its lowest corner
  static Eigen::Vector3d movePoint(const Cell& cell, const Eigen::Vector3d& share,
                                   const Eigen::Vector3d& p_m);

  DeformationConfig config_;
  std::vector<std::pair<Eigen::Vector3d, Pose>> nodes_;  ///< ascending by x
  bool is_rigid_ = false;
  std::unordered_map<mapping::GridIndex, Pose, mapping::GridIndexHash> corners_;
  Cells cells_;
};

}  // namespace tsg::trajectory
