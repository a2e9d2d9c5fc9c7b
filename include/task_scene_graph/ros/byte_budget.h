// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>

#include "task_scene_graph/core/frame.h"

namespace tsg::ros_interface {

/// Bytes of the frame's images.
inline std::size_t countBytes(const RgbdFrame& frame) {
  std::size_t bytes = 0;
  for (const auto* image : {&frame.color.image, &frame.depth.image, &frame.published_color.image}) {
    bytes += image->total() * image->elemSize();
  }
  return bytes;
}

/// Bounds the bytes of what waits in a queue. Thread-safe.
class ByteBudget {
 public:
  /// Held by an item for as long as it waits; gives its bytes back when it dies, which may be after
  /// the budget.
  using Share = std::shared_ptr<const void>;

  explicit ByteBudget(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// Null if the item does not fit beside those that wait. One alone always fits.
  Share reserve(std::size_t bytes) {
    const auto used = used_;
    if (const std::size_t before = used->fetch_add(bytes);
        before > 0 && before + bytes > max_bytes_) {
      used->fetch_sub(bytes);
      return nullptr;
    }
    return Share(used.get(), [used, bytes](const void*) { used->fetch_sub(bytes); });
  }

  std::size_t usedBytes() const { return *used_; }
  std::size_t maxBytes() const { return max_bytes_; }

 private:
  std::size_t max_bytes_;
  std::shared_ptr<std::atomic<std::size_t>> used_ = std::make_shared<std::atomic<std::size_t>>(0);
};

}  // namespace tsg::ros_interface
