// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace tsg {

/// A 64-bit number in which every bit depends on every bit of `value` (one step of SplitMix64
/// [Steele et al. 2014]).
inline std::uint64_t mixBits(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15ULL;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ULL;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebULL;
  return value ^ (value >> 31);
}

}  // namespace tsg
