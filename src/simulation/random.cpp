// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/random.h"

#include <cmath>

namespace tsg::simulation {

std::uint64_t hashText(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : text) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  return mixBits(hash);
}

double toNormal(std::uint64_t bits) {
  const auto part = [bits](int shift) { return static_cast<double>((bits >> shift) & 0xffff); };
  // Each part has mean 32767.5 and, in units of 65536, variance 1/12.
  return ((part(0) + part(16) + part(32) + part(48)) - 131070.0) / 65536.0 * std::sqrt(3.0);
}

int Random::integer(int count) {
  return static_cast<int>(engine_() % static_cast<std::uint64_t>(count));
}

double Random::normal() {
  double sum = 0.0;
  for (int i = 0; i < 12; ++i) sum += uniform();
  return sum - 6.0;
}

}  // namespace tsg::simulation
