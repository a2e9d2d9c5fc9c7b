// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/correct_map.h"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "task_scene_graph/core/parallel.h"
#include "task_scene_graph/map/merge.h"
#include "task_scene_graph/map/moving.h"
#include "task_scene_graph/places/move_memory.h"
#include "task_scene_graph/places/place_extractor.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::trajectory {
namespace {

void movePrimitives(const Keyframes& before, const Correction& correction, int num_threads,
                    CorrectedMap& result) {
  const std::vector<ObjectPrimitivePtr>& primitives = result.map.primitives();
  std::vector<ObjectPrimitivePtr> moved(primitives.size());
  parallelFor(primitives.size(), num_threads, [&](std::size_t i) {
    moved[i] = movePrimitive(primitives[i], before, correction);
    if (moved[i] == primitives[i]) moved[i] = nullptr;
  });
  moved.erase(std::remove(moved.begin(), moved.end(), nullptr), moved.end());
  result.num_moved_primitives = moved.size();
  result.map.addPrimitives(std::move(moved));
}

std::size_t countMoved(const std::vector<mapping::BlockMesh>& before,
                       const std::vector<mapping::BlockMesh>& after) {
  std::size_t same = 0;
  auto next = after.begin();
  for (const mapping::BlockMesh& block : before) {
    while (next != after.end() && mapping::isBefore(next->block, block.block)) ++next;
    if (next != after.end() && next->mesh == block.mesh) ++same;
  }
  return before.size() - same;
}

void moveBackground(const DeformationConfig& config, const Keyframes& before,
                    const Correction& correction, CorrectedMap& result) {
  Deformation deformation(before, correction, config);
  const auto motionAt = [&](const Eigen::Vector3d& p_m) { return deformation.motionAt(p_m); };
  map::Map& map = result.map;
  map.setPlaces(std::make_shared<const PlaceGraph>(
      movePlaces(*map.places(), deformation, config.num_threads)));
  map.setPlaceMemory(std::make_shared<const places::PlaceMemory>(
      places::moveMemory(*map.placeMemory(), motionAt)));
  if (map.occupancy() != nullptr) {
    map.setOccupancy(
        std::make_shared<const mapping::OccupancyMap>(map.occupancy()->moved(motionAt)));
  }
  if (map.meshBlocks().empty()) return;
  auto blocks = moveMesh(map.meshBlocks(), map.meshVoxelSize(), deformation, config.num_threads);
  result.num_moved_blocks = countMoved(map.meshBlocks(), blocks);
  map.setMesh(map.meshVoxelSize(), std::move(blocks));
}

}  // namespace

Pose computeMotion(const ObjectPrimitive& primitive, const Keyframes& before,
                   const Correction& correction) {
  std::vector<std::pair<Pose, double>> motions;
  const Stamp best = primitive.views.best.stamp;
  const bool has_best = primitive.first_seen <= best && best <= primitive.last_seen;
  const double share = has_best ? 1.0 / 3.0 : 0.5;
  motions.emplace_back(correction.at(before.anchorsAt(primitive.first_seen)), share);
  if (has_best) motions.emplace_back(correction.at(before.anchorsAt(best)), share);
  motions.emplace_back(correction.at(before.anchorsAt(primitive.last_seen)), share);
  return blend(motions);
}

ObjectPrimitivePtr movePrimitive(const ObjectPrimitivePtr& primitive, const Keyframes& before,
                                 const Correction& correction) {
  const Pose motion = computeMotion(*primitive, before, correction);
  if (isIdentity(motion)) return primitive;
  return std::make_shared<const ObjectPrimitive>(map::movePrimitive(*primitive, motion));
}

PlaceGraph movePlaces(const PlaceGraph& places, const Deformation& deformation, int num_threads) {
  PlaceGraph moved = places;
  parallelFor(moved.places.size(), num_threads, [&](std::size_t i) {
    Place& place = moved.places[i];
    place.position_m = deformation.motionAt(place.position_m) * place.position_m;
  });
  return moved;
}

std::vector<mapping::BlockMesh> moveMesh(const std::vector<mapping::BlockMesh>& blocks,
                                         double voxel_size_m, Deformation& deformation,
                                         int num_threads) {
  for (const mapping::BlockMesh& block : blocks) deformation.prepare(*block.mesh);
  using Parts = map::BlockGatherer::Meshes;
  std::vector<std::optional<Parts>> moved(blocks.size());
  parallelFor(blocks.size(), num_threads, [&](std::size_t i) {
    if (!deformation.moves(*blocks[i].mesh)) return;
    Mesh mesh = *blocks[i].mesh;
    if (!deformation.move(mesh)) return;
    map::BlockGatherer gatherer(voxel_size_m * mapping::kBlockSide);
    gatherer.startMesh();
    for (const auto& triangle : mesh.triangles) gatherer.add(mesh, triangle);
    moved[i] = gatherer.take();
  });
  std::vector<mapping::BlockMesh> result;
  Parts all;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!moved[i]) {
      result.push_back(blocks[i]);
      continue;
    }
    for (auto& [index, mesh] : *moved[i]) {
      const auto [found, is_new] = all.try_emplace(index);
      if (is_new) {
        found->second = std::move(mesh);
      } else {
        found->second.append(mesh);
      }
    }
  }
  map::addToBlocks(std::move(all), result);
  return result;
}

CorrectedMap correctMap(const map::Map& map, const Keyframes& before, const Correction& correction,
                        const DeformationConfig& config) {
  if (before.frame() != map.worldFrame()) {
    throw std::invalid_argument("the keyframes are in frame '" + before.frame() +
                                "', expected the map's, '" + map.worldFrame() + "'");
  }
  CorrectedMap result{map};
  if (correction.isIdentity()) return result;
  if (before.isEmpty()) throw std::invalid_argument("the map cannot follow: it has no keyframe");
  movePrimitives(before, correction, config.num_threads, result);
  moveBackground(config, before, correction, result);
  result.map.setTrajectory(
      std::make_shared<const Trajectory>(applyCorrection(correction, before, *map.trajectory())));
  return result;
}

void updatePlaces(const places::PlacesConfig& config, map::Map& map) {
  const places::PlaceMemory& memory = *map.placeMemory();
  if (memory.isEmpty()) return;
  places::PlaceExtractor extractor(config);
  extractor.restore(memory, memory.voxel_size_m);
  map.setPlaces(std::make_shared<const PlaceGraph>(extractor.graph()));
  map.setPlaceMemory(std::make_shared<const places::PlaceMemory>(extractor.memory()));
}

void joinMap(const places::PlacesConfig& config, map::Map& map) {
  updatePlaces(config, map);
  map::recluster(map);
}

}  // namespace tsg::trajectory
