// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "task_scene_graph/core/stamp.h"

namespace tsg::ros_interface {

/// Judges the stamps of a stream: each is later than the one before, or it says what else it is.
class StampOrder {
 public:
  enum class Kind {
    kNext,       ///< later than all before
    kDuplicate,  ///< the same stamp as the newest one
    kLate,       ///< a little older than the newest one: messages overtook each other
    kJumpBack    ///< much older: time was set back, as when a bag is played in a loop
  };

  explicit StampOrder(double jump_back_s = 1.0) : jump_back_s_(jump_back_s) {}

  /// After a jump back the order starts anew from that stamp.
  Kind update(Stamp stamp) {
    if (!newest_ || *newest_ < stamp) {
      newest_ = stamp;
      return Kind::kNext;
    }
    if (*newest_ == stamp) return Kind::kDuplicate;
    if (secondsBetween(stamp, *newest_) < jump_back_s_) return Kind::kLate;
    newest_ = stamp;
    return Kind::kJumpBack;
  }

 private:
  double jump_back_s_;
  std::optional<Stamp> newest_;
};

}  // namespace tsg::ros_interface
