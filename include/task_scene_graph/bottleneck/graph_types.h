// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace tsg::bottleneck {

/// Whoever inserts a primitive names it; any number, unique.
using NodeKey = std::uint64_t;

/// Which merges are allowed.
enum class Adjacency {
  kBoxOverlap,  ///< primitives whose boxes share a volume [Clio24, Sec. IV-B]
  kGiven        ///< edges that are inserted, as in the place graph
};

}  // namespace tsg::bottleneck
