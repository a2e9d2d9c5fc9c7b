// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/evaluation/region_scores.h"

/// Regions of map folders against true rooms.
namespace tsg::evaluation {

/// The places of a scene graph and the regions that they are in.
struct MapRegions {
  PlaceGraph places;  ///< without edges, without embeddings
  std::vector<std::vector<PlaceId>> regions;
};

/// Reads nodes of the layers PLACES and ROOMS of spark_dsg's JSON and the edges between them.
/// @throws std::runtime_error naming the file and what was found.
MapRegions loadMapRegions(const std::string& path);

/// A storey's observed free floor: centres of the free cells of its ground plan.
struct FloorSamples {
  double floor_m = 0.0;  ///< world z, as the first line of the file says
  double cell_m = 0.1;   ///< side of a cell
  SamplePoints samples_m;
};

/// The storeys of a map folder, `floor_<n>.yaml` with its image (binary PGM), as map_server reads
/// them. Empty if there is none. @throws std::runtime_error naming the file and what was found.
std::vector<FloorSamples> loadFloors(const std::string& map_folder);

/// Reads rooms: `rooms.json` of a generated world ({rooms: [{name, rectangle_m, floor_z_m,
/// height_m}]}) or of a rendered house ([{name, rects}]); or a YAML file as Hydra has it, id ->
/// [{center, extents, rotation: {w, x, y, z}}], of which only the turn about z is taken.
/// @throws std::runtime_error naming the file and what was found.
std::vector<TrueRoom> loadRoomTruth(const std::string& path);

/// Scores over the free floor of all storeys; a place's clearance reaches horizontally, on its own
/// storey. Rooms of which less than 1 m^2 is free floor do not count: they were not visited.
RegionScores scoreRegions(const MapRegions& map, const std::vector<FloorSamples>& floors,
                          const std::vector<TrueRoom>& rooms);

}  // namespace tsg::evaluation
