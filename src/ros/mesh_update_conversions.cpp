// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/mesh_update_conversions.h"

#include <utility>

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"

namespace tsg::ros_interface {
namespace {

using BlockMeshes = std::vector<std::pair<mapping::GridIndex, std::shared_ptr<const Mesh>>>;

msg::MeshBlock makeBlock(const mapping::GridIndex& block, const Mesh& mesh) {
  msg::MeshBlock message;
  message.x = block.x();
  message.y = block.y();
  message.z = block.z();
  message.mesh = toMessage(mesh);
  return message;
}

BlockMeshes readChanged(const msg::MeshUpdate& message) {
  BlockMeshes blocks;
  blocks.reserve(message.changed.size());
  for (const auto& block : message.changed) {
    blocks.emplace_back(mapping::GridIndex(block.x, block.y, block.z),
                        std::make_shared<const Mesh>(fromMessage(block.mesh)));
  }
  return blocks;
}

std::vector<mapping::GridIndex> readRemoved(const msg::MeshUpdate& message) {
  const auto& flat = message.removed;
  if (flat.size() % 3 != 0) {
    throw InputError("mesh update has " + std::to_string(flat.size()) +
                     " values in removed, expected a multiple of 3");
  }
  std::vector<mapping::GridIndex> blocks;
  for (std::size_t i = 0; i < flat.size(); i += 3) {
    blocks.emplace_back(flat[i], flat[i + 1], flat[i + 2]);
  }
  return blocks;
}

/// Collects blocks into messages of bounded size.
class Packer {
 public:
  Packer(const msg::MeshUpdate& empty, const MeshUpdateWriter::Send& send)
      : empty_(empty), message_(empty), send_(send) {}

  void add(const mapping::GridIndex& block, const Mesh& mesh) {
    num_vertices_ += mesh.vertices.size();
    if (num_vertices_ > MeshUpdateWriter::kMaxVertices && !message_.changed.empty()) {
      flush(false);
      num_vertices_ = mesh.vertices.size();
    }
    message_.changed.push_back(makeBlock(block, mesh));
  }
  void remove(const mapping::GridIndex& block) {
    message_.removed.insert(message_.removed.end(), block.data(), block.data() + 3);
  }
  bool isEmpty() const { return message_.changed.empty() && message_.removed.empty(); }
  std::uint32_t numSent() const { return num_sent_; }

  /// Numbers the message by what `empty` is: changes count in sequence, parts in part.
  void flush(bool is_last) {
    (message_.part == 0 ? message_.sequence : message_.part) += num_sent_++;
    message_.is_last = is_last ? 1 : 0;
    send_(message_);
    message_ = empty_;
  }

 private:
  const msg::MeshUpdate& empty_;
  msg::MeshUpdate message_;
  const MeshUpdateWriter::Send& send_;
  std::size_t num_vertices_ = 0;
  std::uint32_t num_sent_ = 0;
};

}  // namespace

msg::MeshUpdate MeshUpdateWriter::makeMessage(Stamp stamp) const {
  msg::MeshUpdate message;
  message.header.stamp = toRosTime(stamp);
  message.header.frame_id = world_frame_;
  message.block_size = static_cast<float>(block_size_m_);
  message.sequence = sequence_;
  return message;
}

void MeshUpdateWriter::sendChanges(const mapping::MeshUpdate& update, Stamp stamp,
                                   const Send& send) {
  msg::MeshUpdate empty = makeMessage(stamp);
  ++empty.sequence;
  Packer packer(empty, send);
  for (const auto& block : update.removed) packer.remove(block);
  for (const auto& block : update.changed) packer.add(block.block, *block.mesh);
  if (!packer.isEmpty()) packer.flush(true);
  sequence_ += packer.numSent();
}

void MeshUpdateWriter::sendAll(const std::vector<mapping::GridIndex>& blocks,
                               const FindMesh& find_mesh, Stamp stamp, const Send& send) const {
  msg::MeshUpdate empty = makeMessage(stamp);
  empty.part = 1;
  Packer packer(empty, send);
  for (const auto& block : blocks) packer.add(block, *find_mesh(block));
  packer.flush(true);
}

MeshUpdateReader::Status MeshUpdateReader::classify(const msg::MeshUpdate& message) const {
  const bool is_first = message.part == 1 || (message.part == 0 && message.sequence == 1);
  if (is_first) return Status::kApplied;
  if (state_ == State::kWaiting) return Status::kWaiting;
  const bool follows = state_ == State::kPartial
                           ? message.sequence == sequence_ && message.part == part_ + 1
                           : message.sequence == sequence_ + 1 && message.part == 0;
  return follows ? Status::kApplied : Status::kLost;
}

MeshUpdateReader::Result MeshUpdateReader::apply(const msg::MeshUpdate& message) {
  Result result;
  result.status = classify(message);
  if (result.status == Status::kLost) state_ = State::kWaiting;
  if (result.status != Status::kApplied) return result;
  const BlockMeshes changed = readChanged(message);
  const auto removed = readRemoved(message);
  result.has_restarted = message.part == 1 || message.sequence == 1;
  if (result.has_restarted && message.part <= 1) blocks_.clear();
  for (const auto& [block, mesh] : changed) {
    blocks_[block] = mesh;
    result.changed.push_back(block);
  }
  for (const auto& block : removed) {
    blocks_.erase(block);
    result.changed.push_back(block);
  }
  state_ = message.part != 0 && message.is_last == 0 ? State::kPartial : State::kComplete;
  sequence_ = message.sequence;
  part_ = message.part;
  return result;
}

void MeshUpdateReader::reset() {
  blocks_.clear();
  state_ = State::kWaiting;
}

}  // namespace tsg::ros_interface
