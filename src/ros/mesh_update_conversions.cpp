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

std::size_t countBytes(const Mesh& mesh) {
  return 15 * mesh.vertices.size() + 12 * mesh.triangles.size() + 24;
}

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
  msg::MeshUpdate message = makeMessage(stamp);
  std::size_t num_bytes = 0;
  const auto flush = [&](bool is_last) {
    message.sequence = ++sequence_;
    message.is_last = is_last ? 1 : 0;
    send(message);
    message = makeMessage(stamp);
    num_bytes = 0;
  };
  for (const auto& block : update.removed) {
    message.removed.insert(message.removed.end(), block.data(), block.data() + 3);
  }
  for (const auto& block : update.changed) {
    const std::size_t more = countBytes(*block.mesh);
    if (num_bytes + more > kMaxBytes && !message.changed.empty()) flush(false);
    num_bytes += more;
    message.changed.push_back(makeBlock(block.block, *block.mesh));
  }
  if (!update.changed.empty() || !update.removed.empty()) flush(true);
}

msg::MeshUpdate MeshUpdateWriter::makePart(const std::vector<mapping::GridIndex>& blocks,
                                           std::size_t& next, const mapping::MeshTable& meshes,
                                           Stamp stamp, std::uint32_t part) const {
  msg::MeshUpdate message = makeMessage(stamp);
  message.part = part;
  std::size_t num_bytes = 0;
  for (; next < blocks.size(); ++next) {
    const auto mesh = meshes.find(blocks[next]).load();
    if (mesh == nullptr) continue;
    num_bytes += countBytes(*mesh);
    if (num_bytes > kMaxBytes && !message.changed.empty()) return message;
    message.changed.push_back(makeBlock(blocks[next], *mesh));
  }
  message.is_last = 1;
  return message;
}

msg::MeshUpdate MeshUpdateWriter::makeEmpty(Stamp stamp) const {
  std::size_t next = 0;
  return makePart({}, next, {}, stamp, 1);
}

MeshUpdateReader::Status MeshUpdateReader::classify(const msg::MeshUpdate& message) const {
  if (message.part == 1) return Status::kApplied;
  const bool is_first_change = message.part == 0 && message.sequence == 1;
  if (state_ == State::kWaiting) return is_first_change ? Status::kApplied : Status::kWaiting;
  if (message.part != 0) {
    const bool follows = state_ == State::kPartial && message.part == part_ + 1;
    return follows ? Status::kApplied : Status::kLost;
  }
  if (message.sequence <= first_part_sequence_) return Status::kWaiting;  // part 1 has it already
  const bool is_part_missing =
      state_ == State::kPartial && changes_since_part_ >= kMaxChangesBetweenParts;
  const bool follows = message.sequence == sequence_ + 1 && !is_part_missing;
  return follows ? Status::kApplied : Status::kLost;
}

MeshUpdateReader::Result MeshUpdateReader::apply(const msg::MeshUpdate& message) {
  Result result;
  result.status = classify(message);
  if (result.status == Status::kLost) state_ = State::kWaiting;
  if (result.status != Status::kApplied) return result;
  const BlockMeshes changed = readChanged(message);
  const auto removed = readRemoved(message);
  result.has_restarted = message.part == 1 || state_ == State::kWaiting;
  if (result.has_restarted) {
    blocks_.clear();
    first_part_sequence_ = message.part == 1 ? message.sequence : 0;
  }
  for (const auto& [block, mesh] : changed) {
    blocks_[block] = mesh;
    result.changed.push_back(block);
  }
  for (const auto& block : removed) {
    blocks_.erase(block);
    result.changed.push_back(block);
  }
  if (message.part <= 1) sequence_ = message.sequence;  // later parts tell of no change
  if (message.part != 0) part_ = message.part;
  changes_since_part_ = message.part != 0 ? 0 : changes_since_part_ + 1;
  if (message.part != 0 || state_ == State::kWaiting) {
    const bool more_parts_follow = message.part != 0 && message.is_last == 0;
    state_ = more_parts_follow ? State::kPartial : State::kComplete;
  }
  return result;
}

void MeshUpdateReader::reset() {
  blocks_.clear();
  state_ = State::kWaiting;
}

}  // namespace tsg::ros_interface
