// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/places/place_memory.h"
#include "task_scene_graph/places/places_config.h"

namespace tsg::test {

/// Heap that the graph of places takes, by what it is for; bytes. Without the places' embeddings.
struct PlaceHeap {
  double nodes = 0.0;  ///< the places, and the ways in tiles
  double links = 0.0;  ///< what they see, with the edges among it
  double cells = 0.0;  ///< the choice of places, coarse cell by coarse cell

  double graph() const { return nodes + links; }
};

/// Computes the layers of a memory once more and measures copies of them. O(map).
PlaceHeap measurePlaceHeap(const places::PlaceMemory& memory, const places::PlacesConfig& config);

}  // namespace tsg::test
