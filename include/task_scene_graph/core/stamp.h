// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>

namespace tsg {

/// Time of a sensor message: nanoseconds since the epoch of the message clock (never the wall
/// clock).
struct Stamp {
  std::int64_t ns = 0;

  static Stamp fromSeconds(double seconds) {
    return {static_cast<std::int64_t>(std::llround(seconds * 1e9))};
  }
  double seconds() const { return static_cast<double>(ns) * 1e-9; }
};

inline bool operator==(Stamp a, Stamp b) { return a.ns == b.ns; }
inline bool operator!=(Stamp a, Stamp b) { return a.ns != b.ns; }
inline bool operator<(Stamp a, Stamp b) { return a.ns < b.ns; }
inline bool operator<=(Stamp a, Stamp b) { return a.ns <= b.ns; }

/// Seconds from `earlier` to `later`; negative if the order is the other way round.
inline double secondsBetween(Stamp earlier, Stamp later) {
  return static_cast<double>(later.ns - earlier.ns) * 1e-9;
}

}  // namespace tsg

template <>
struct std::hash<tsg::Stamp> {
  std::size_t operator()(tsg::Stamp stamp) const noexcept {
    return std::hash<std::int64_t>()(stamp.ns);
  }
};
