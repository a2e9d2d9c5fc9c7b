// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <tf2/buffer_core.h>

#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "task_scene_graph/core/stamp.h"

namespace tsg::ros_interface {

/// When the moving links of tf were published. tf2 keeps that to itself, and interpolates between
/// two transforms however far they are apart. Thread-safe.
class TransformHistory {
 public:
  /// @param memory_s  how long a link's stamps are kept, counted from its newest one
  explicit TransformHistory(double memory_s);

  /// Notes a transform of /tf, in any order of stamps. Static ones have no place here.
  void add(const geometry_msgs::TransformStamped& transform);
  void clear();

  /// Two neighbouring transforms of one link.
  struct Gap {
    std::string child;  ///< frame that the link leads to from its parent
    Stamp before;
    Stamp after;
    double length_s = 0.0;
    double usual_s = 0.0;  ///< median of this link's spacings around it, itself included
  };
  /// The longest gap around a stamp among the links between two frames of `tf`; nothing where all
  /// have a transform at the stamp itself or are static.
  std::optional<Gap> findGap(const tf2::BufferCore& tf, const std::string& target,
                             const std::string& source, Stamp stamp) const;

 private:
  using Stamps_ns = std::deque<std::int64_t>;  ///< ascending
  static double computeUsual(const Stamps_ns& stamps, std::size_t after);

  const std::int64_t memory_ns_;
  mutable std::mutex mutex_;
  std::map<std::string, Stamps_ns> links_;  ///< by child frame
};

}  // namespace tsg::ros_interface
