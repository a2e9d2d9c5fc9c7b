// SPDX-License-Identifier: BSD-3-Clause
// What a PlaceExtractor remembers, and how two memories become one.
#include "task_scene_graph/places/place_memory.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "place_layers.h"
#include "task_scene_graph/mapping/moved_voxels.h"
#include "task_scene_graph/places/move_memory.h"
#include "task_scene_graph/places/place_extractor.h"

namespace tsg::places {
namespace {

constexpr double kSamePlace_m = 1e-6;  ///< what is computed again from the same voxels

std::string describeSizes(double found_m, double expected_m) {
  std::ostringstream text;
  text << "has voxels of " << found_m << " m, expected " << expected_m << " m";
  return text.str();
}

std::vector<VoxelBlock> listBlocks(const VoxelMap& voxels) {
  std::vector<VoxelBlock> blocks;
  for (const auto& [column, by_z] : voxels.columns()) {
    for (const auto& [z, block] : by_z) {
      blocks.push_back({GridIndex(column.first, column.second, z), *block});
    }
  }
  return blocks;
}

/// Blocks by index, into which voxels are put that nobody has observed yet.
class VoxelGatherer {
 public:
  VoxelGatherer(std::vector<VoxelBlock> blocks, double voxel_size_m) : size_m_(voxel_size_m) {
    for (VoxelBlock& block : blocks) blocks_[toKey(block.index)] = block;
  }

  void add(const VoxelBlock& block, const Pose& T_target_source) {
    mapping::forEachMovedVoxel(block.index, size_m_, T_target_source,
                               [&](const GridIndex& target, const GridIndex& source) {
                                 put(target, block.distances_m[offsetOf(source)]);
                               });
  }

  /// Ascending by (x, y, z).
  std::vector<VoxelBlock> take() const {
    std::vector<VoxelBlock> blocks;
    for (const auto& [key, block] : blocks_) blocks.push_back(block);
    return blocks;
  }

 private:
  using Key = std::tuple<int, int, int>;

  static Key toKey(const GridIndex& index) { return {index.x(), index.y(), index.z()}; }
  static std::size_t offsetOf(const GridIndex& voxel) {
    return static_cast<std::size_t>(
        mapping::TsdfBlock::computeLinearIndex(mapping::TsdfVolume::computeLocalIndex(voxel)));
  }
  void put(const GridIndex& voxel, float distance_m) {
    if (isNotObserved(distance_m)) return;
    const GridIndex index = mapping::TsdfVolume::computeBlockIndex(voxel);
    const auto [found, is_new] = blocks_.try_emplace(toKey(index));
    if (is_new) {
      found->second.index = index;
      found->second.distances_m.fill(kNotObserved);
    }
    float& known = found->second.distances_m[offsetOf(voxel)];
    if (isNotObserved(known)) known = distance_m;
  }

  double size_m_;
  std::map<Key, VoxelBlock> blocks_;
};

/// The way of `b` at the height at which `a`'s camera is carried.
WayMemory mergeWays(const WayMemory& a, const WayMemory& b, const Pose& T_a_b) {
  WayMemory merged = a;
  const bool has_height = !a.segments.empty() && !b.segments.empty();
  const double raise_m = has_height ? a.camera_height_m - b.camera_height_m : 0.0;
  if (a.segments.empty()) merged.camera_height_m = b.camera_height_m;
  const auto move = [&](const Eigen::Vector3d& p_b) {
    return Eigen::Vector3d(T_a_b * p_b + raise_m * Eigen::Vector3d::UnitZ());
  };
  for (const auto& segment : b.segments) {
    merged.segments.push_back({move(segment.from_m), move(segment.to_m)});
  }
  merged.height_counts.resize(std::max(a.height_counts.size(), b.height_counts.size()), 0);
  for (std::size_t i = 0; i < b.height_counts.size(); ++i) {
    merged.height_counts[i] += has_height ? 0U : b.height_counts[i];
  }
  return merged;
}

/// The voxel in which a place lies.
GridIndex computeKey(const PlaceMemory& memory, const Eigen::Vector3d& p_m) {
  const double size_m = memory.isEmpty() ? 1.0 : memory.voxel_size_m;
  return (p_m / size_m).array().floor().cast<int>();
}

}  // namespace

PlaceMemory PlaceExtractor::memory() const {
  PlaceMemory memory;
  memory.voxel_size_m = voxels_.voxelSize();
  memory.blocks = listBlocks(voxels_);
  memory.way = layers_->way().memory();
  memory.views.assign(views_.views().begin(), views_.views().end());
  for (const auto& [id, state] : places_) {
    memory.places.push_back({state->place, state->key, state->views()});
    memory.places.back().place.embedding = {};
    memory.places.back().place.num_views = 0;
  }
  memory.next_id = next_id_;
  memory.stamp = stamp_;
  memory.plan = plan();
  return memory;
}

void PlaceExtractor::restore(const PlaceMemory& memory, double voxel_size_m) {
  if (!memory.isEmpty() && memory.voxel_size_m != voxel_size_m) {
    throw std::invalid_argument("the map's free space " +
                                describeSizes(memory.voxel_size_m, voxel_size_m) +
                                " (free_space/tsdf/voxel_size_m)");
  }
  *this = PlaceExtractor(config_);
  voxels_.restore(memory.voxel_size_m, memory.blocks);
  for (const View& view : memory.views) views_.add(view);
  if (!memory.views.empty()) embedding_size_ = memory.views.back().embedding.size();
  stamp_ = memory.stamp;
  next_id_ = memory.next_id;
  WayMap way(config_);
  if (!memory.isEmpty()) way.restore(memory.way, memory.voxel_size_m);
  const CellSet cells = layers_->updateAll(voxels_, way);
  const std::vector<GridIndex> touched(cells.begin(), cells.end());
  Changes changes = findChanges(touched);
  rememberPlaces(memory, changes);
  updateEdges(touched);
}

/// By the voxel in which they lie; the others by their distance, as after any update.
void PlaceExtractor::rememberPlaces(const PlaceMemory& memory, Changes& changes) {
  std::unordered_map<GridIndex, const RememberedPlace*, mapping::GridIndexHash> by_key;
  for (const RememberedPlace& known : memory.places) by_key.emplace(known.key, &known);
  std::map<PlaceId, const ViewSum*> views;
  for (PlaceState& added : changes.added) {
    const auto known = by_key.find(added.key);
    if (known == by_key.end()) continue;
    const RememberedPlace& place = *known->second;
    if ((place.place.position_m - added.place.position_m).norm() > kSamePlace_m) continue;
    added.place.id = place.place.id;
    if (place.views) views[place.place.id] = &*place.views;
    by_key.erase(known);
  }
  for (const RememberedPlace& known : memory.places) {
    next_id_ = std::max(next_id_, known.place.id.value + 1);
    const auto found = by_key.find(known.key);
    if (found == by_key.end() || found->second != &known) continue;
    changes.removed.emplace_back();
    changes.removed.back().place = known.place;
  }
  matchIds(changes);
  // places are kept by id: what comes in that order comes at the end
  std::stable_sort(changes.added.begin(), changes.added.end(),
                   [](const PlaceState& a, const PlaceState& b) {
                     const bool is_a_new = !a.place.id.isValid();  // new ids are the largest
                     const bool is_b_new = !b.place.id.isValid();
                     return is_a_new == is_b_new ? a.place.id < b.place.id : is_b_new;
                   });
  addPlaces(changes);
  for (const auto& [id, sum] : views) places_.at(id)->setViews(*sum);
}

PlaceMemory mergeMemories(const PlaceMemory& a, const PlaceMemory& b, const Pose& T_a_b,
                          std::uint64_t id_offset) {
  if (!a.isEmpty() && !b.isEmpty() && a.voxel_size_m != b.voxel_size_m) {
    throw std::invalid_argument("the second map's free space " +
                                describeSizes(b.voxel_size_m, a.voxel_size_m) +
                                " as the first one's");
  }
  PlaceMemory merged;
  merged.voxel_size_m = a.isEmpty() ? b.voxel_size_m : a.voxel_size_m;
  if (!merged.isEmpty()) {
    VoxelGatherer voxels(a.blocks, merged.voxel_size_m);
    for (const VoxelBlock& block : b.blocks) voxels.add(block, T_a_b);
    merged.blocks = voxels.take();
  }
  merged.way = mergeWays(a.way, b.way, T_a_b);
  merged.views = a.views;
  const Pose T_b_a = T_a_b.inverse();
  for (View view : b.views) {
    view.T_camera_world = view.T_camera_world * T_b_a;
    merged.views.push_back(std::move(view));
  }
  for (const RememberedPlace& known : a.places) {
    merged.places.push_back({known.place, known.key, std::nullopt});
  }
  for (const RememberedPlace& known : b.places) {
    Place place = known.place;
    place.id.value += id_offset;
    place.position_m = T_a_b * place.position_m;
    merged.places.push_back({place, computeKey(merged, place.position_m), std::nullopt});
  }
  merged.next_id = std::max(a.next_id, b.next_id + id_offset);
  merged.stamp = std::max(a.stamp, b.stamp);
  return merged;
}

PlaceMemory moveMemory(const PlaceMemory& memory, const MotionField& motion) {
  PlaceMemory moved = memory;
  moved.plan = GroundPlan();
  if (!memory.isEmpty()) {
    VoxelGatherer voxels({}, memory.voxel_size_m);
    for (const VoxelBlock& block : memory.blocks) {
      voxels.add(block, motion(mapping::computeBlockMiddle(block.index, memory.voxel_size_m)));
    }
    moved.blocks = voxels.take();
  }
  const auto move = [&](const Eigen::Vector3d& p_m) { return Eigen::Vector3d(motion(p_m) * p_m); };
  const auto movePose = [&](CameraPose& pose) {
    pose.T_world_camera = motion(pose.T_world_camera.translation()) * pose.T_world_camera;
  };
  for (auto& segment : moved.way.segments) {
    segment.from_m = move(segment.from_m);
    segment.to_m = move(segment.to_m);
  }
  if (moved.way.last) movePose(*moved.way.last);
  for (CameraPose& pose : moved.way.waiting) movePose(pose);
  for (View& view : moved.views) {
    const Eigen::Vector3d camera_m = view.T_camera_world.inverse().translation();
    view.T_camera_world = view.T_camera_world * motion(camera_m).inverse();
  }
  for (RememberedPlace& known : moved.places) {
    known.place.position_m = move(known.place.position_m);
    known.key = computeKey(memory, known.place.position_m);
  }
  return moved;
}

}  // namespace tsg::places
