// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/stamp.h"

namespace tsg {

/// Poses over time, from a file or as they arrive. Not thread-safe.
class Trajectory {
 public:
  /// In any order; a stamp that is there already gets the new pose. O(log poses).
  void add(Stamp stamp, const Pose& pose);

  bool isEmpty() const { return poses_.empty(); }
  std::size_t size() const { return poses_.size(); }
  /// The trajectory must not be empty.
  Stamp first() const { return {poses_.begin()->first}; }
  Stamp last() const { return {poses_.rbegin()->first}; }

  /// Pose at `stamp`: positions linear, rotations spherical between the two nearest in time.
  /// Nothing before the first or after the last pose, or where the two are further apart than
  /// `max_gap_s`. O(log poses).
  std::optional<Pose> interpolate(Stamp stamp, double max_gap_s) const;

  /// Seconds between the two poses around `stamp`; 0 outside and where there is one at `stamp`.
  double gapAt(Stamp stamp) const;

  /// All poses by stamp in nanoseconds.
  const std::map<std::int64_t, Pose>& poses() const { return poses_; }

  /// Forgets the poses before `stamp`, but keeps the last of them.
  void forgetBefore(Stamp stamp);

 private:
  std::map<std::int64_t, Pose> poses_;  ///< by nanoseconds
};

/// Reads a trajectory in the format of the TUM RGB-D benchmark: lines `stamp tx ty tz qx qy qz qw`
/// (seconds, metres), `#` begins a comment. Lines with a NaN are left out (trackers write them
/// while they are lost). Stamps keep every nanosecond.
/// @throws std::runtime_error naming the file, the line and what was expected.
Trajectory loadTumTrajectory(const std::string& path);

/// Writes a trajectory in that format, whole or not at all (core/files.h); stamps keep every
/// nanosecond, poses every bit.
/// @param what  of which frame in which the poses are, for a comment: "T_world_camera"
/// @throws std::runtime_error naming the path.
void writeTumTrajectory(const std::string& path, const Trajectory& trajectory,
                        const std::string& what);

}  // namespace tsg
