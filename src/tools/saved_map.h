// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iostream>
#include <string>
#include <utility>

#include "task_scene_graph/map/files.h"

namespace tsg::tools {

/// A saved map for a program that somebody called; what loading has to say is told him.
/// @throws as map::loadMap().
inline map::Map loadMap(const std::string& folder, const map::MapUse& use = {}) {
  map::LoadedMap loaded = map::loadMap(folder, use);
  for (const auto& note : loaded.notes) std::cerr << "map '" << folder << "': " << note << '\n';
  return std::move(loaded.map);
}

}  // namespace tsg::tools
