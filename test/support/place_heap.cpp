// SPDX-License-Identifier: BSD-3-Clause
#include "place_heap.h"

#include <malloc.h>

#include "places/place_layers.h"

namespace tsg::test {
namespace {

/// Bytes in use, with what the allocator adds to each piece.
double readHeap() {
#if __GLIBC_PREREQ(2, 33)
  return static_cast<double>(mallinfo2().uordblks);
#else
  return static_cast<double>(static_cast<unsigned>(mallinfo().uordblks));
#endif
}

template <typename Layer>
double measureCopy(const Layer& layer) {
  const double before = readHeap();
  const Layer copy = layer;
  return readHeap() - before;
}

}  // namespace

PlaceHeap measurePlaceHeap(const places::PlaceMemory& memory, const places::PlacesConfig& config) {
  places::VoxelMap voxels;
  voxels.restore(memory.voxel_size_m, memory.blocks);
  places::WayMap way(config);
  way.restore(memory.way, memory.voxel_size_m);
  places::PlaceLayers layers(config);
  layers.updateAll(voxels, way);
  PlaceHeap heap;
  for (const auto& [key, node] : layers.links().nodes()) heap.links += measureCopy(node.seen);
  heap.nodes = measureCopy(layers.links()) - heap.links;
  heap.cells = measureCopy(layers.cells());
  return heap;
}

}  // namespace tsg::test
