// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/pipeline/map_files.h"

#include "task_scene_graph/mapping/ply.h"
#include "task_scene_graph/mapping/vertex_labels.h"

namespace tsg::pipeline {

void writeMeshFile(const std::filesystem::path& folder, const Mesh& mesh,
                   const std::vector<ObjectPrimitivePtr>& primitives,
                   const std::map<PrimitiveId, std::int32_t>& object_of_primitive,
                   double max_distance_m) {
  mapping::writePly(folder / "mesh.ply", mesh,
                    mapping::labelVertices(mesh, primitives, object_of_primitive, max_distance_m));
}

void writeOccupancyFiles(const std::filesystem::path& folder, const mapping::OccupancyMap* map) {
  if (map == nullptr) return;
  map->write(folder / "map.bt");
  map->write(folder / "map.ot");
}

}  // namespace tsg::pipeline
