// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <random>
#include <string_view>

#include "task_scene_graph/core/mix_bits.h"

namespace tsg::simulation {

/// FNV-1a hash of the bytes, mixed; the same on every platform.
std::uint64_t hashText(std::string_view text);

inline std::uint64_t combineSeeds(std::uint64_t a, std::uint64_t b) {
  return mixBits(mixBits(a) + 0x9e3779b97f4a7c15ULL * b);
}

/// A number in [0, 1) from the upper 53 bits.
inline double toUnitInterval(std::uint64_t bits) {
  return static_cast<double>(bits >> 11) * 0x1.0p-53;
}

/// Zero mean, unit variance, within +-3.5: the sum of the four 16-bit numbers in `bits`, scaled.
double toNormal(std::uint64_t bits);

/// Seeded random numbers that are the same with every standard library: std::mt19937_64 is
/// specified to the bit, the distributions of <random> are not, so the mapping is done here.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(mixBits(seed)) {}

  /// In [0, 1).
  double uniform() { return toUnitInterval(engine_()); }
  /// In [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// In [0, count), count >= 1.
  int integer(int count);
  bool chance(double probability) { return uniform() < probability; }
  /// Zero mean, unit variance, within +-6: the sum of 12 uniform numbers less 6 (no libm call).
  double normal();
  /// A generator for a named part of the job: drawing more numbers in one part moves no other part.
  Random fork(std::string_view name) { return Random(combineSeeds(engine_(), hashText(name))); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace tsg::simulation
