// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/places/places_config.h"

namespace tsg::places {

/// A place a metre or so, for a body of 1 m: few enough to be told one by one in a test.
inline PlacesConfig makeSparseConfig() {
  PlacesConfig config;
  config.body_height_m = 1.0;
  config.cell_size_m = 1.0;
  config.merge_distance_m = 0.5;
  config.fill_distance_m = 0.75;
  config.min_component_size = 3;
  return config;
}

}  // namespace tsg::places
