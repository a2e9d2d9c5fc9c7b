// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace tsg::mapping {

/// Corner i of a cell lies at (i & 1, i >> 1 & 1, i >> 2 & 1). Edge 4 * a + k runs along axis a
/// (0 = x, 1 = y, 2 = z) from the k-th corner whose coordinate on that axis is 0.
struct CellEdge {
  int from;  ///< corner with the lower coordinate on `axis`
  int to;
  int axis;
};

constexpr int kCellEdges = 12;

/// The cell's edges. Computed once.
const std::array<CellEdge, kCellEdges>& cellEdges();

/// Triangles of a cell, as triples of edges, by the set of corners (bit i = corner i) that lie
/// inside, that is behind the surface.
using CellTriangles = std::vector<std::array<std::uint8_t, 3>>;

/// All 256 cases, derived once: on each face of the cell the cut edges are joined pairwise, on an
/// ambiguous face so that each inside corner is cut off alone; the directed segments close to loops
/// and each loop is cut into a fan. The rule depends on the face's corners only, so two cells
/// agree on the face they share and the surface is closed.
const std::array<CellTriangles, 256>& cellTriangles();

}  // namespace tsg::mapping
