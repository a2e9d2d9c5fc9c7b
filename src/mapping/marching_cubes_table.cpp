// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/marching_cubes_table.h"

#include <algorithm>
#include <utility>

namespace tsg::mapping {
namespace {

constexpr int kNone = -1;

std::array<CellEdge, kCellEdges> makeEdges() {
  std::array<CellEdge, kCellEdges> edges{};
  std::size_t next = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int corner = 0; corner < 8; ++corner) {
      if ((corner >> axis & 1) == 0) edges[next++] = {corner, corner | 1 << axis, axis};
    }
  }
  return edges;
}

int findEdge(int corner_a, int corner_b) {
  const auto& edges = cellEdges();
  const int from = std::min(corner_a, corner_b);
  const int to = std::max(corner_a, corner_b);
  const auto found = std::find_if(edges.begin(), edges.end(), [&](const CellEdge& edge) {
    return edge.from == from && edge.to == to;
  });
  return static_cast<int>(found - edges.begin());
}

/// Corners of a face, counter-clockwise seen from outside the cell.
std::array<int, 4> makeFace(int axis, bool upper) {
  const int u = 1 << (axis + 1) % 3;  // (axis, u, v) is right-handed
  const int v = 1 << (axis + 2) % 3;
  const int base = upper ? 1 << axis : 0;
  if (upper) return {base, base | u, base | u | v, base | v};
  return {base, base | v, base | u | v, base | u};
}

/// next[e] = edge that follows edge e on the outline of the surface in this cell, or kNone.
using Successors = std::array<int, kCellEdges>;

/// Adds the segments of one face. Walking round the face, the surface is entered where the corners
/// change from outside to inside, and left at the next change back: that joins the two cut edges
/// round one run of inside corners. With two runs (an ambiguous face) each is a single corner.
void joinFace(const std::array<int, 4>& face, int inside, Successors& next) {
  const auto isInside = [&](std::size_t i) { return (inside >> face[i % 4] & 1) != 0; };
  for (std::size_t i = 0; i < 4; ++i) {
    if (isInside(i) || !isInside(i + 1)) continue;
    std::size_t last = i + 1;
    while (isInside(last + 1)) ++last;
    const int enter = findEdge(face[i], face[(i + 1) % 4]);
    const int leave = findEdge(face[last % 4], face[(last + 1) % 4]);
    next[static_cast<std::size_t>(enter)] = leave;
  }
}

bool areOnOneFace(int edge_a, int edge_b) {
  const auto corners = [](int edge) {
    const auto& e = cellEdges()[static_cast<std::size_t>(edge)];
    return std::array<int, 2>{e.from, e.to};
  };
  int all = 7;
  int any = 0;
  for (const int edge : {edge_a, edge_b}) {
    for (const int corner : corners(edge)) {
      all &= corner;
      any |= corner;
    }
  }
  return all != 0 || any != 7;
}

/// How many diagonals of the fan lie on a face of the cell, where they could meet a triangle of the
/// neighbouring cell.
int countDiagonalsOnFaces(const std::vector<int>& loop, std::size_t apex) {
  int count = 0;
  for (std::size_t i = 2; i + 1 < loop.size(); ++i) {
    count += areOnOneFace(loop[apex], loop[(apex + i) % loop.size()]) ? 1 : 0;
  }
  return count;
}

void addFan(const std::vector<int>& loop, CellTriangles& triangles) {
  std::size_t apex = 0;
  for (std::size_t i = 1; i < loop.size(); ++i) {
    if (countDiagonalsOnFaces(loop, i) < countDiagonalsOnFaces(loop, apex)) apex = i;
  }
  const auto at = [&](std::size_t i) {
    return static_cast<std::uint8_t>(loop[(apex + i) % loop.size()]);
  };
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) triangles.push_back({at(0), at(i), at(i + 1)});
}

CellTriangles makeTriangles(int inside) {
  Successors next;
  next.fill(kNone);
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool upper : {false, true}) joinFace(makeFace(axis, upper), inside, next);
  }
  CellTriangles triangles;
  for (int start = 0; start < kCellEdges; ++start) {
    std::vector<int> loop;
    for (int edge = start; next[static_cast<std::size_t>(edge)] != kNone;) {
      loop.push_back(edge);
      edge = std::exchange(next[static_cast<std::size_t>(edge)], kNone);
    }
    if (!loop.empty()) addFan(loop, triangles);
  }
  return triangles;
}

std::array<CellTriangles, 256> makeAllTriangles() {
  std::array<CellTriangles, 256> cases;
  for (int inside = 0; inside < 256; ++inside) {
    cases[static_cast<std::size_t>(inside)] = makeTriangles(inside);
  }
  return cases;
}

}  // namespace

const std::array<CellEdge, kCellEdges>& cellEdges() {
  static const auto edges = makeEdges();
  return edges;
}

const std::array<CellTriangles, 256>& cellTriangles() {
  static const auto cases = makeAllTriangles();
  return cases;
}

}  // namespace tsg::mapping
