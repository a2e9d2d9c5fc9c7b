// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/map/merge.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <unordered_set>
#include <utility>

#include "task_scene_graph/map/moving.h"
#include "task_scene_graph/mapping/tsdf_integrator.h"
#include "task_scene_graph/places/place_extractor.h"

namespace tsg::map {
namespace {

using mapping::BlockMesh;
using mapping::GridIndex;
using Cells = std::unordered_set<GridIndex, mapping::GridIndexHash>;

template <typename Value>
void requireSame(const char* what, const Value& a, const Value& b, const char* hint = "") {
  if (a == b || a == Value{} || b == Value{}) return;
  std::ostringstream message;
  message << "the second map has " << what << " " << b << ", expected " << a
          << " as the first one has" << hint;
  throw std::invalid_argument(message.str());
}

std::string quote(const std::string& text) { return text.empty() ? "" : "'" + text + "'"; }

void requireMergeable(const Map& a, const Map& b, const MergeOptions& options) {
  requireSame("embeddings of model set", quote(a.settings().model_set),
              quote(b.settings().model_set));
  requireSame("embeddings of size", a.embeddingSize(), b.embeddingSize());
  requireSame("a mesh of voxels of [m]", a.meshVoxelSize(), b.meshVoxelSize());
  requireSame("free space in voxels of [m]", a.placeMemory()->voxel_size_m,
              b.placeMemory()->voxel_size_m);
  if (!options.is_transform_given) {
    requireSame("coordinates in frame", quote(a.worldFrame()), quote(b.worldFrame()),
                "; or a transform");
  }
  const double tilt_rad = computeTilt(options.T_a_b);
  if (tilt_rad <= kMaxTilt_rad) return;
  std::ostringstream message;
  message << "the transform tilts by " << tilt_rad / kMaxTilt_rad * 5.0
          << " degrees, expected a turn about the vertical (z), 5 degrees at most";
  throw std::invalid_argument(message.str());
}

ObjectPrimitivePtr move(const ObjectPrimitive& primitive, const Pose& T, std::uint64_t id_offset) {
  auto moved = std::make_shared<ObjectPrimitive>(movePrimitive(primitive, T));
  moved->id.value += id_offset;
  return moved;
}

/// Cells of a voxel's size that a surface is in, and their neighbours.
Cells findCells(const std::vector<BlockMesh>& blocks, double voxel_size_m) {
  Cells cells;
  for (const auto& block : blocks) {
    for (const auto& triangle : block.mesh->triangles) {
      const GridIndex cell = findCell(*block.mesh, triangle, voxel_size_m);
      for (int i = 0; i < 27; ++i) {
        cells.insert(cell + GridIndex(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
      }
    }
  }
  return cells;
}

void mergeMeshes(const Map& b, const Pose& T_a_b, Map& merged) {
  if (b.meshBlocks().empty()) return;
  const double voxel_size_m =
      merged.meshVoxelSize() > 0.0 ? merged.meshVoxelSize() : b.meshVoxelSize();
  const Cells known = findCells(merged.meshBlocks(), voxel_size_m);
  BlockGatherer gatherer(voxel_size_m * mapping::kBlockSide);
  for (const auto& block : b.meshBlocks()) {
    Mesh mesh = *block.mesh;
    moveMesh(T_a_b, mesh);
    gatherer.startMesh();
    for (const auto& triangle : mesh.triangles) {
      if (known.count(findCell(mesh, triangle, voxel_size_m)) > 0) continue;
      gatherer.add(mesh, triangle);
    }
  }
  std::vector<BlockMesh> blocks = merged.meshBlocks();
  addToBlocks(gatherer.take(), blocks);
  merged.setMesh(voxel_size_m, std::move(blocks));
}

void mergeTrajectories(const Map& b, const Pose& T_a_b, Map& merged) {
  auto trajectory = std::make_shared<Trajectory>(*merged.trajectory());
  for (const auto& [ns, pose] : b.trajectory()->poses()) {
    if (merged.trajectory()->poses().count(ns) == 0) trajectory->add({ns}, T_a_b * pose);
  }
  merged.setTrajectory(std::move(trajectory));
}

/// Of all places, found anew; of a map without free space, its graph beside the other's.
void mergePlaces(const Map& a, const Map& b, const MergeOptions& options, std::uint64_t offset,
                 Map& merged) {
  const auto memory =
      places::mergeMemories(*a.placeMemory(), *b.placeMemory(), options.T_a_b, offset);
  if (!memory.isEmpty()) {
    places::PlaceExtractor extractor(options.places);
    extractor.restore(memory, memory.voxel_size_m);
    merged.setPlaceMemory(std::make_shared<const places::PlaceMemory>(extractor.memory()));
    merged.setPlaces(std::make_shared<const PlaceGraph>(extractor.graph()));
    return;
  }
  auto graph = std::make_shared<PlaceGraph>(*a.places());
  graph->stamp = std::max(a.places()->stamp, b.places()->stamp);
  for (Place place : b.places()->places) {
    place.id.value += offset;
    place.position_m = options.T_a_b * place.position_m;
    graph->places.push_back(std::move(place));
  }
  for (PlaceEdge edge : b.places()->edges) {
    edge.a.value += offset;
    edge.b.value += offset;
    graph->edges.push_back(edge);
  }
  merged.setPlaces(std::move(graph));
}

std::uint64_t maxPrimitiveId(const Map& map) {
  return map.primitives().empty() ? 0 : map.primitives().back()->id.value;
}

std::uint64_t maxPlaceId(const Map& map) {
  const auto& places = map.places()->places;
  const std::uint64_t remembered = map.placeMemory()->next_id - 1;
  return std::max(remembered, places.empty() ? 0 : places.back().id.value);
}

/// `b`, and what it was merged from itself.
void recordSources(const Map& b, const MergeOptions& options, std::uint64_t primitive_offset,
                   std::uint64_t place_offset, Map& merged) {
  std::vector<MapSource> sources = merged.sources();
  sources.push_back({options.name_b, options.T_a_b, primitive_offset, place_offset,
                     maxPrimitiveId(b) + primitive_offset});
  for (MapSource source : b.sources()) {
    source.T_map_source = options.T_a_b * source.T_map_source;
    source.primitive_id_offset += primitive_offset;
    source.place_id_offset += place_offset;
    source.max_primitive_id += primitive_offset;
    sources.push_back(std::move(source));
  }
  merged.setSources(std::move(sources));
}

}  // namespace

double computeTilt(const Pose& motion) {
  return std::acos(std::clamp(motion.linear()(2, 2), -1.0, 1.0));
}

void recluster(Map& map) {
  scene_graph::SceneGraphBuilder builder(map.settings().scene_graph, map.worldFrame());
  builder.setObjectTasks(map.objectTasks());
  builder.setPlaceTasks(map.placeTasks());
  restoreBuilder(map, builder);
  map.setClusters(builder.computeObjectClusters(), builder.computeRegionClusters());
}

Map mergeMaps(const Map& a, const Map& b, const MergeOptions& options) {
  requireMergeable(a, b, options);
  Map merged = a;
  const std::uint64_t primitive_offset = maxPrimitiveId(a);
  const std::uint64_t place_offset = maxPlaceId(a);
  std::vector<ObjectPrimitivePtr> moved;
  for (const auto& primitive : b.primitives()) {
    moved.push_back(move(*primitive, options.T_a_b, primitive_offset));
  }
  merged.addPrimitives(std::move(moved));
  if (a.objectTasks().size() == 0) merged.setTasks(b.objectTasks(), b.placeTasks());
  mergePlaces(a, b, options, place_offset, merged);
  mergeMeshes(b, options.T_a_b, merged);
  mergeTrajectories(b, options.T_a_b, merged);
  recordSources(b, options, primitive_offset, place_offset, merged);
  merged.setClusters(a.objectClusters(), a.regionClusters());
  recluster(merged);
  return merged;
}

}  // namespace tsg::map
