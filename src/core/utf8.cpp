// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/utf8.h"

#include <cstddef>

namespace tsg {
namespace {

/// What may follow a first byte: how many bytes, and the range of the first of them [Unicode, Table
/// 3-7].
struct Tail {
  std::size_t count;
  unsigned char first_min;
  unsigned char first_max;
};

/// No byte at all may follow a byte that begins nothing: `first_min` exceeds `first_max` then.
Tail findTail(unsigned char head) {
  if (head < 0x80) return {0, 0x80, 0xbf};
  if (head < 0xc2) return {1, 0xff, 0x00};
  if (head < 0xe0) return {1, 0x80, 0xbf};
  if (head == 0xe0) return {2, 0xa0, 0xbf};
  if (head == 0xed) return {2, 0x80, 0x9f};
  if (head < 0xf0) return {2, 0x80, 0xbf};
  if (head == 0xf0) return {3, 0x90, 0xbf};
  if (head < 0xf4) return {3, 0x80, 0xbf};
  if (head == 0xf4) return {3, 0x80, 0x8f};
  return {1, 0xff, 0x00};
}

}  // namespace

bool isValidUtf8(const std::string& text) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  for (std::size_t i = 0; i < text.size();) {
    const Tail tail = findTail(at(i));
    if (i + tail.count >= text.size()) return false;
    for (std::size_t k = 1; k <= tail.count; ++k) {
      const unsigned char min = k == 1 ? tail.first_min : 0x80;
      const unsigned char max = k == 1 ? tail.first_max : 0xbf;
      if (at(i + k) < min || at(i + k) > max) return false;
    }
    i += tail.count + 1;
  }
  return true;
}

}  // namespace tsg
