// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "task_scene_graph/core/mesh.h"
#include "task_scene_graph/mapping/mesh_archive.h"
#include "task_scene_graph/mapping/mesh_table.h"
#include "task_scene_graph/mapping/thin_surfaces.h"
#include "task_scene_graph/mapping/tsdf_integrator.h"

namespace tsg::mapping {

/// Parameters of the background map. A block is archived when it is both far and long unseen, so
/// that a flat stays whole while memory and time per frame do not grow with a large building.
struct BackgroundConfig {
  IntegratorConfig tsdf;
  bool with_mesh = true;
  double mesh_min_weight = 1e-4;
  bool archive_blocks = true;
  double archive_distance_m = 10.0;
  double archive_unseen_s = 30.0;
  double pose_jump_m = 1.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.group("tsdf", self.tsdf);
    v.field("with_mesh", self.with_mesh, {}, "",
            "keep a mesh; without it the map is a TSDF with an active window only");
    v.field("mesh_min_weight", self.mesh_min_weight, {0.0, 1e9}, "",
            "voxels of at most this weight give no surface");
    v.field("archive_blocks", self.archive_blocks, {}, "",
            "drop the voxels of blocks far away and long unseen; their mesh stays, in a file");
    v.field("archive_distance_m", self.archive_distance_m, {0.0, 1e6}, "m",
            "archived blocks are farther than this from the camera");
    v.field("archive_unseen_s", self.archive_unseen_s, {0.0, 1e9}, "s",
            "archived blocks have not been seen for longer than this");
    v.field("pose_jump_m", self.pose_jump_m, {0.0, 1e6}, "m",
            "a camera that moves farther than this from frame to frame is counted as a jump");
  }
};

struct BlockMesh {
  GridIndex block;
  std::shared_ptr<const Mesh> mesh;  ///< not empty; world frame
};

/// What changed since the update before; ascending by (z, y, x).
struct MeshUpdate {
  std::vector<BlockMesh> changed;
  std::vector<GridIndex> removed;  ///< had a mesh before and have none now
};

struct BackgroundCounters {
  std::size_t frames_integrated = 0;
  std::size_t frames_without_depth = 0;  ///< no valid reading, or a pose out of range
  std::size_t blocks_remeshed = 0;
  std::size_t blocks_archived = 0;
  std::size_t frames_back_in_time = 0;  ///< integrated, but older than a frame before
  std::size_t frames_repeated = 0;      ///< integrated, but with the stamp of the newest frame
  std::size_t pose_jumps = 0;           ///< integrated, but farther than pose_jump_m from the last
};

/// The dense map of everything the camera saw: a TSDF of the active window and a mesh of all that
/// was ever there. The mesh of what is archived goes to a temporary file. Not thread-safe; meshes
/// once handed out never change.
class BackgroundMap {
 public:
  /// @throws config::ConfigError as TsdfIntegrator does, or if a value is out of range.
  explicit BackgroundMap(const BackgroundConfig& config);

  const BackgroundConfig& config() const { return config_; }
  const BackgroundCounters& counters() const { return counters_; }
  const TsdfVolume& volume() const { return volume_; }
  const MeshArchive& archive() const { return archive_; }

  /// Integrates a frame, then archives (checked once a second). Time goes by stamps only. The clock
  /// of archiving never goes back: it stands while stamps jump back and goes on from there, as
  /// those of a bag in a loop do. @throws std::invalid_argument as TsdfIntegrator::integrate().
  IntegrationResult integrate(const RgbdFrame& frame);

  /// Meshes the blocks that changed since the last call and those whose cells read them; nothing
  /// without `with_mesh`. O(changed blocks).
  MeshUpdate updateMesh();

  /// The meshes of all blocks as of the last updateMesh(), world frame. O(1).
  const MeshTable& meshes() const { return meshes_; }

  /// The whole map including archived blocks, as of now; welded across block borders. Empty without
  /// `with_mesh`. @throws std::runtime_error as MeshArchive::Record::load().
  Mesh extractMesh() const;

  /// Of a map without a mesh: copies of the blocks that changed since the last call and are still
  /// there. With `carve_free_space`, voxels of surfaces too thin for the TSDF have distance 0 there
  /// (ThinSurfaces). O(changed blocks).
  TsdfVolume takeChangedBlocks();

  /// Begins with the mesh of a map of before, as of blocks that were archived: it stays where
  /// nothing is seen anew. Before the first frame. @param blocks  ascending by (z, y, x)
  /// @throws std::logic_error if a frame was integrated; std::runtime_error as
  /// MeshArchive::store().
  void restore(const std::vector<BlockMesh>& blocks);

  /// Drops the voxels of these blocks now; the mesh stays as it is. When such a place is seen
  /// again, the old mesh stays in cells that are not fully observed anew. Unknown blocks are
  /// ignored.
  void archive(const std::vector<GridIndex>& blocks);

 private:
  using MeshPtr = std::shared_ptr<const Mesh>;
  using Records = std::unordered_map<GridIndex, MeshArchive::RecordPtr, GridIndexHash>;

  void countFrame(const RgbdFrame& frame, IntegrationStatus status);
  void countJump(const RgbdFrame& frame);
  void advanceClock(Stamp stamp);
  std::vector<GridIndex> findBlocksToArchive(const Eigen::Vector3d& camera_m) const;
  /// Blocks whose reported mesh may be wrong, ascending.
  std::vector<GridIndex> computeStaleBlocks() const;
  std::vector<MeshPtr> computeMeshes(const std::vector<GridIndex>& blocks) const;
  /// Adds what the archive holds of the block, where its cells are not fully observed.
  void appendArchived(const GridIndex& block, Mesh& mesh) const;
  bool isCellKnown(const GridIndex& lowest_voxel) const;
  void keepMeshes(const std::vector<GridIndex>& readers);
  void parkMeshes(const std::vector<GridIndex>& readers);
  /// Whether a cell of the block reads voxels that are there.
  bool isActive(const GridIndex& block) const;

  BackgroundConfig config_;
  TsdfIntegrator integrator_;
  TsdfVolume volume_;
  std::optional<ThinSurfaces> thin_;  ///< of carved free space
  BackgroundCounters counters_;
  std::optional<Stamp> newest_;
  Stamp previous_;      ///< stamp of the frame before; less than newest_ after a jump back
  double clock_s_ = 0;  ///< of archiving
  double archived_at_s_ = 0;
  std::optional<Eigen::Vector3d> last_position_m_;  ///< of the camera
  std::unordered_map<GridIndex, double, GridIndexHash> last_seen_s_;
  std::unordered_set<GridIndex, GridIndexHash> dirty_;  ///< changed since the last update
  MeshTable meshes_;                                    ///< as last reported
  MeshArchive archive_;
  Records archived_;  ///< shown in cells that are not fully observed; none is empty
};

}  // namespace tsg::mapping
