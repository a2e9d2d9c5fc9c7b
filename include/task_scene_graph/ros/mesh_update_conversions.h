// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "task_scene_graph/mapping/background_map.h"
#include "task_scene_graph/ros/mesh_markers.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::ros_interface {

/// Background mesh -> MeshUpdate messages of bounded size, numbered so that a subscriber notices
/// what it missed.
class MeshUpdateWriter {
 public:
  static constexpr std::size_t kMaxBytes = 1000000;  ///< of one message's meshes; one block fits
  using Send = std::function<void(const msg::MeshUpdate&)>;

  MeshUpdateWriter(std::string world_frame, double block_size_m)
      : world_frame_(std::move(world_frame)), block_size_m_(block_size_m) {}

  /// An update that nobody is told of.
  void skip() { ++sequence_; }
  /// Sends an update; nothing if it is empty.
  void sendChanges(const mapping::MeshUpdate& update, Stamp stamp, const Send& send);
  /// A part of the whole mesh: blocks[next] and those after it, as many as one message takes, as
  /// they are in `meshes` (passed over if they have none). Moves `next` on; the part that reaches
  /// the end is the last. Changes may be sent between two parts.
  /// @param part  counts from 1
  /// @throws std::runtime_error as mapping::StoredMesh::load().
  msg::MeshUpdate makePart(const std::vector<mapping::GridIndex>& blocks, std::size_t& next,
                           const mapping::MeshTable& meshes, Stamp stamp, std::uint32_t part) const;
  /// The whole mesh of a map without any.
  msg::MeshUpdate makeEmpty(Stamp stamp) const;

 private:
  msg::MeshUpdate makeMessage(Stamp stamp) const;

  std::string world_frame_;
  double block_size_m_;
  std::uint32_t sequence_ = 0;
};

/// MeshUpdate messages -> the mesh, block by block. See MeshUpdate.msg for the rules.
class MeshUpdateReader {
 public:
  using Blocks = std::map<mapping::GridIndex, std::shared_ptr<const Mesh>, BlockOrder>;
  /// More messages than a publisher keeps for a subscriber: the part that did not come is lost.
  static constexpr std::uint32_t kMaxChangesBetweenParts = 64;

  enum class Status {
    kApplied,
    kWaiting,  ///< changes of a mesh that is not here yet, or that came with it; ignored
    kLost,  ///< a message before it is missing; ignored, as all changes until the whole mesh comes
  };
  struct Result {
    Status status = Status::kApplied;
    bool has_restarted = false;               ///< all blocks of before are gone
    std::vector<mapping::GridIndex> changed;  ///< also those removed
  };

  /// @throws InputError for a broken mesh or list of indices; then nothing has changed.
  Result apply(const msg::MeshUpdate& message);

  /// Forgets all blocks, and waits for the whole mesh.
  void reset();
  /// None is empty or null; world frame.
  const Blocks& blocks() const { return blocks_; }
  bool hasWholeMesh() const { return state_ == State::kComplete; }

 private:
  enum class State { kWaiting, kPartial, kComplete };

  Status classify(const msg::MeshUpdate& message) const;

  Blocks blocks_;
  State state_ = State::kWaiting;
  std::uint32_t sequence_ = 0;  ///< of the last change
  std::uint32_t first_part_sequence_ = 0;
  std::uint32_t part_ = 0;
  std::uint32_t changes_since_part_ = 0;
};

}  // namespace tsg::ros_interface
