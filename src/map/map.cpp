// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/map/map.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "task_scene_graph/core/find_by_id.h"

namespace tsg::map {
namespace {

using mapping::BlockMesh;
using mapping::GridIndex;
using scene_graph::ObjectCluster;
using scene_graph::RegionCluster;

PrimitiveId idOf(const ObjectPrimitivePtr& primitive) { return primitive->id; }

bool isBefore(const BlockMesh& a, const BlockMesh& b) {
  return mapping::isBefore(a.block, b.block);
}

template <typename Cluster>
const Cluster* findClusterById(const std::vector<Cluster>& clusters, decltype(Cluster::id) id) {
  const auto found = findById(clusters, id, [](const Cluster& cluster) { return cluster.id; });
  return found == clusters.end() ? nullptr : &*found;
}

template <typename Cluster, typename Member>
void checkClusters(const char* what, const std::vector<Cluster>& clusters,
                   std::vector<Member> Cluster::*members) {
  decltype(Cluster::id) last;
  for (const Cluster& cluster : clusters) {
    const std::string name =
        "map: cluster " + std::to_string(cluster.id.value) + " of " + std::string(what);
    if (!(last < cluster.id)) throw std::invalid_argument(name + ": expected ascending ids from 1");
    if ((cluster.*members).empty()) throw std::invalid_argument(name + " has no member");
    last = cluster.id;
  }
}

}  // namespace

Map::Map(std::string world_frame)
    : world_frame_(std::move(world_frame)),
      object_tasks_(std::make_shared<const scene_graph::TaskList>()),
      place_tasks_(object_tasks_),
      places_(std::make_shared<const PlaceGraph>()),
      trajectory_(std::make_shared<const Trajectory>()),
      place_memory_(std::make_shared<const places::PlaceMemory>()) {}

Stamp Map::stamp() const {
  Stamp newest = places_->stamp;
  for (const auto& primitive : primitives_) newest = std::max(newest, primitive->last_seen);
  return newest;
}

void Map::setTasks(scene_graph::TaskList objects, scene_graph::TaskList places) {
  objects.validate("object tasks of the map");
  places.validate("place tasks of the map");
  object_tasks_ = std::make_shared<const scene_graph::TaskList>(std::move(objects));
  place_tasks_ = std::make_shared<const scene_graph::TaskList>(std::move(places));
}

ObjectPrimitivePtr Map::findPrimitive(PrimitiveId id) const {
  const auto found = findById(primitives_, id, idOf);
  return found == primitives_.end() ? nullptr : *found;
}

void Map::addPrimitives(std::vector<ObjectPrimitivePtr> primitives) {
  for (const auto& primitive : primitives) {
    if (primitive != nullptr && primitive->id.isValid()) continue;
    throw std::invalid_argument(primitive == nullptr
                                    ? "map: a primitive is null"
                                    : "map: a primitive has id 0, expected ids from 1");
  }
  const auto isLess = [](const auto& a, const auto& b) { return a->id < b->id; };
  std::stable_sort(primitives.begin(), primitives.end(), isLess);
  std::vector<ObjectPrimitivePtr> merged;
  merged.reserve(primitives_.size() + primitives.size());
  std::merge(primitives_.begin(), primitives_.end(), primitives.begin(), primitives.end(),
             std::back_inserter(merged), isLess);
  primitives_.clear();
  for (auto& primitive : merged) {  // of one id the last, which is the newest
    if (!primitives_.empty() && primitives_.back()->id == primitive->id) primitives_.pop_back();
    primitives_.push_back(std::move(primitive));
  }
}

bool Map::erasePrimitive(PrimitiveId id) {
  const auto found = findById(primitives_, id, idOf);
  if (found == primitives_.end()) return false;
  primitives_.erase(found);
  return true;
}

const Place* Map::findPlace(PlaceId id) const {
  const auto found = findById(places_->places, id, [](const Place& place) { return place.id; });
  return found == places_->places.end() ? nullptr : &*found;
}

void Map::setPlaces(PlaceGraphPtr places) {
  if (places == nullptr) throw std::invalid_argument("map: the place graph is null");
  places_ = std::move(places);
}

const ObjectCluster* Map::findCluster(ObjectId id) const {
  return findClusterById(object_clusters_, id);
}

const RegionCluster* Map::findCluster(RegionId id) const {
  return findClusterById(region_clusters_, id);
}

void Map::setClusters(std::vector<ObjectCluster> objects, std::vector<RegionCluster> regions) {
  checkClusters("primitives", objects, &ObjectCluster::primitives);
  checkClusters("places", regions, &RegionCluster::places);
  object_clusters_ = std::move(objects);
  region_clusters_ = std::move(regions);
}

std::shared_ptr<const Mesh> Map::findMesh(const GridIndex& block) const {
  const auto found = std::lower_bound(mesh_blocks_.begin(), mesh_blocks_.end(),
                                      BlockMesh{block, nullptr}, isBefore);
  return found != mesh_blocks_.end() && found->block == block ? found->mesh : nullptr;
}

void Map::setMesh(double voxel_size_m, std::vector<BlockMesh> blocks) {
  if (!(voxel_size_m > 0.0)) {
    throw std::invalid_argument("map: the mesh's voxel size is " + std::to_string(voxel_size_m) +
                                " m, expected more than 0");
  }
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].mesh == nullptr) throw std::invalid_argument("map: a block's mesh is null");
    if (i == 0 || isBefore(blocks[i - 1], blocks[i])) continue;
    throw std::invalid_argument("map: blocks of the mesh do not ascend by (z, y, x)");
  }
  mesh_voxel_size_m_ = voxel_size_m;
  mesh_blocks_ = std::move(blocks);
}

void Map::updateMesh(const mapping::MeshUpdate& update) {
  const auto isReplaced = [&](const BlockMesh& block) {
    return std::binary_search(update.changed.begin(), update.changed.end(), block, isBefore) ||
           std::binary_search(update.removed.begin(), update.removed.end(), block.block,
                              mapping::isBefore);
  };
  std::vector<BlockMesh> kept;
  std::remove_copy_if(mesh_blocks_.begin(), mesh_blocks_.end(), std::back_inserter(kept),
                      isReplaced);
  mesh_blocks_.clear();
  std::merge(kept.begin(), kept.end(), update.changed.begin(), update.changed.end(),
             std::back_inserter(mesh_blocks_), isBefore);
}

void Map::setTrajectory(std::shared_ptr<const Trajectory> trajectory) {
  if (trajectory == nullptr) throw std::invalid_argument("map: the trajectory is null");
  trajectory_ = std::move(trajectory);
}

void Map::setPlaceMemory(std::shared_ptr<const places::PlaceMemory> memory) {
  if (memory == nullptr) throw std::invalid_argument("map: the memory of the places is null");
  place_memory_ = std::move(memory);
}

Eigen::Index Map::embeddingSize() const {
  for (const auto& primitive : primitives_) {
    if (primitive->embedding.size() > 0) return primitive->embedding.size();
  }
  for (const Place& place : places_->places) {
    if (place.embedding.size() > 0) return place.embedding.size();
  }
  return std::max(object_tasks_->embeddings.cols(), place_tasks_->embeddings.cols());
}

}  // namespace tsg::map
