// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/mesh_publisher.h"

#include <exception>
#include <utility>
#include <vector>

namespace tsg::ros_interface {

MeshPublisher::MeshPublisher(ros::NodeHandle& handle, LateSubscribers& late, StageReport& report,
                             const std::string& world_frame, double block_size_m)
    : report_(report),
      markers_(world_frame),
      blocks_(world_frame, block_size_m),
      markers_publisher_(late.advertise<visualization_msgs::MarkerArray>(
          handle, "mesh", kQueueSize, [this](PartSender& sender) { serveMarkers(sender); })),
      blocks_publisher_(late.advertise<msg::MeshUpdate>(
          handle, "mesh_blocks", kQueueSize, [this](PartSender& sender) { serveBlocks(sender); })),
      worker_(1, [this](Wake) { process(); }) {}

void MeshPublisher::add(const mapping::MeshUpdate& update, const mapping::MeshTable& meshes,
                        Stamp stamp) {
  {
    const std::lock_guard<std::mutex> lock(pending_mutex_);
    for (const auto& changed : update.changed) pending_.touched.insert(changed.block);
    pending_.touched.insert(update.removed.begin(), update.removed.end());
    pending_.meshes = meshes;
    pending_.stamp = stamp;
  }
  worker_.push({});
}

void MeshPublisher::clear(Stamp stamp) {
  {
    const std::lock_guard<std::mutex> lock(pending_mutex_);
    pending_ = {true, {}, {}, stamp};
  }
  worker_.push({});
}

void MeshPublisher::process() {
  Pending pending;
  {
    const std::lock_guard<std::mutex> lock(pending_mutex_);
    std::swap(pending, pending_);
    pending_.meshes = pending.meshes;
  }
  try {
    const std::lock_guard<std::mutex> lock(send_mutex_);
    meshes_ = pending.meshes;
    stamp_ = pending.stamp;
    if (pending.is_cleared) sendClear();
    if (pending.touched.empty()) return;
    sendMarkers(pending.touched);
    sendBlocks(pending.touched);
  } catch (const std::exception& e) {
    report_.warn("mesh", std::string("mesh not published: ") + e.what());
  }
}

void MeshPublisher::sendClear() {
  ++num_clears_;
  markers_publisher_.publish(markers_.clear());
  blocks_.skip();
  blocks_publisher_.publish(blocks_.makeEmpty(stamp_));
}

void MeshPublisher::sendMarkers(const Blocks& touched) {
  if (markers_publisher_.getNumSubscribers() == 0) return;
  Blocks touched_chunks;
  for (const auto& block : touched) touched_chunks.insert(mapping::computeMeshChunk(block));
  const std::vector<mapping::GridIndex> chunks(touched_chunks.begin(), touched_chunks.end());
  for (std::size_t next = 0; next < chunks.size();) {
    const auto message = markers_.makePart(chunks, next, meshes_);
    if (!message.markers.empty()) markers_publisher_.publish(message);
  }
}

void MeshPublisher::sendBlocks(const Blocks& touched) {
  if (blocks_publisher_.getNumSubscribers() == 0) return blocks_.skip();
  mapping::MeshUpdate update;
  for (const auto& block : touched) {
    const auto mesh = meshes_.find(block).load();
    if (mesh != nullptr) {
      update.changed.push_back({block, mesh});
    } else {
      update.removed.push_back(block);
    }
  }
  blocks_.sendChanges(update, stamp_,
                      [&](const msg::MeshUpdate& part) { blocks_publisher_.publish(part); });
}

void MeshPublisher::serveMarkers(PartSender& sender) {
  std::unique_lock<std::mutex> lock(send_mutex_);
  const auto chunks = meshes_.chunks();
  const auto clears = num_clears_;
  for (std::size_t next = 0; next < chunks.size() && clears == num_clears_;) {
    // Each part as things are now: what is sent to all meanwhile may come before it, never after.
    const auto message = markers_.makePart(chunks, next, meshes_);
    if (!message.markers.empty()) sender.send(message);
    lock.unlock();
    if (!sender.waitForRoom()) return;
    lock.lock();
  }
}

void MeshPublisher::serveBlocks(PartSender& sender) {
  std::unique_lock<std::mutex> lock(send_mutex_);
  const auto blocks = meshes_.blocks();
  const auto clears = num_clears_;
  std::size_t next = 0;
  for (std::uint32_t part = 1; clears == num_clears_; ++part) {
    const auto message = blocks_.makePart(blocks, next, meshes_, stamp_, part);
    sender.send(message);
    if (message.is_last != 0) return;
    lock.unlock();
    if (!sender.waitForRoom()) return;
    lock.lock();
  }
}

}  // namespace tsg::ros_interface
