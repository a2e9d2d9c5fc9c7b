// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "task_scene_graph/config/settings.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/map/folder.h"
#include "task_scene_graph/mapping/background_map.h"
#include "task_scene_graph/mapping/occupancy_map.h"
#include "task_scene_graph/places/place_memory.h"
#include "task_scene_graph/scene_graph/builder.h"
#include "task_scene_graph/scene_graph/clusters.h"
#include "task_scene_graph/scene_graph/config.h"
#include "task_scene_graph/scene_graph/tasks.h"

namespace tsg::map {

/// What a map was made with.
struct MapSettings {
  std::string model_set;                      ///< its name; "" without one
  scene_graph::SceneGraphConfig scene_graph;  ///< what the clusters were made with
  std::vector<config::StageSettings> stages;  ///< every parameter in force, for `settings.yaml`
  std::vector<config::YamlLine> record;       ///< what they were used for, likewise
};

class Map;
/// A snapshot of a map: nothing can change it any more, any thread may read it.
using MapPtr = std::shared_ptr<const Map>;

/// Everything that is known, as one value: tasks and settings, object primitives, places, clusters
/// of both with stable ids, the blocks of the background mesh, the camera's trajectory, the name of
/// the frame that all of it is in. The scene graph follows from it, see computeSceneGraph().
///
/// Copies are cheap: primitives, places, meshes and the trajectory are immutable and shared, so a
/// copy costs a few bytes for each of them. Lists ascend by id. A map is not thread-safe, its
/// snapshots are.
class Map {
 public:
  explicit Map(std::string world_frame = "world");

  const std::string& worldFrame() const { return world_frame_; }
  /// Newest sight of a primitive or of the places; 0 while there is neither.
  Stamp stamp() const;
  /// Nothing has been seen yet: no primitive, no places.
  bool isEmpty() const { return stamp() == Stamp{}; }
  MapPtr snapshot() const { return std::make_shared<const Map>(*this); }

  const scene_graph::TaskList& objectTasks() const { return *object_tasks_; }
  const scene_graph::TaskList& placeTasks() const { return *place_tasks_; }
  /// @throws config::ConfigError if a list is not valid; the former ones stay then.
  void setTasks(scene_graph::TaskList objects, scene_graph::TaskList places);
  const MapSettings& settings() const { return settings_; }
  void setSettings(MapSettings settings) { settings_ = std::move(settings); }

  const std::vector<ObjectPrimitivePtr>& primitives() const { return primitives_; }
  /// Null if there is none. O(log primitives).
  ObjectPrimitivePtr findPrimitive(PrimitiveId id) const;
  /// Puts primitives in; each takes the place of the one of its id, if there is one. All or none.
  /// @throws std::invalid_argument if one is null or has no id. O((all + new) log new).
  void addPrimitives(std::vector<ObjectPrimitivePtr> primitives);
  /// False if there is none. The clusters are the caller's to set anew. O(primitives).
  bool erasePrimitive(PrimitiveId id);

  const PlaceGraphPtr& places() const { return places_; }  ///< never null
  /// Null if there is none. O(log places).
  const Place* findPlace(PlaceId id) const;
  /// @throws std::invalid_argument for null.
  void setPlaces(PlaceGraphPtr places);

  const std::vector<scene_graph::ObjectCluster>& objectClusters() const { return object_clusters_; }
  const std::vector<scene_graph::RegionCluster>& regionClusters() const { return region_clusters_; }
  /// Null if there is none. O(log clusters).
  const scene_graph::ObjectCluster* findCluster(ObjectId id) const;
  const scene_graph::RegionCluster* findCluster(RegionId id) const;
  /// @throws std::invalid_argument naming the cluster unless ids ascend from 1 and each has
  /// members.
  void setClusters(std::vector<scene_graph::ObjectCluster> objects,
                   std::vector<scene_graph::RegionCluster> regions);

  /// Ascending by (z, y, x).
  const std::vector<mapping::BlockMesh>& meshBlocks() const { return mesh_blocks_; }
  /// Of the volume that the mesh is the surface of, metres; 0: the map has no mesh.
  double meshVoxelSize() const { return mesh_voxel_size_m_; }
  /// Null if the block has no mesh. O(log blocks).
  std::shared_ptr<const Mesh> findMesh(const mapping::GridIndex& block) const;
  /// Replaces the whole mesh. @throws std::invalid_argument unless the size is above 0 and blocks
  /// ascend by (z, y, x).
  void setMesh(double voxel_size_m, std::vector<mapping::BlockMesh> blocks);
  /// Puts changed blocks in and takes removed ones out. O(blocks).
  void updateMesh(const mapping::MeshUpdate& update);

  /// Of the camera, T_world_camera; never null.
  const std::shared_ptr<const Trajectory>& trajectory() const { return trajectory_; }
  /// @throws std::invalid_argument for null.
  void setTrajectory(std::shared_ptr<const Trajectory> trajectory);

  /// What the places go on from; never null.
  const std::shared_ptr<const places::PlaceMemory>& placeMemory() const { return place_memory_; }
  /// @throws std::invalid_argument for null.
  void setPlaceMemory(std::shared_ptr<const places::PlaceMemory> memory);

  /// Null unless an occupancy map is kept.
  const std::shared_ptr<const mapping::OccupancyMap>& occupancy() const { return occupancy_; }
  void setOccupancy(std::shared_ptr<const mapping::OccupancyMap> occupancy) {
    occupancy_ = std::move(occupancy);
  }

  /// Maps that went into this one, see mergeMaps().
  const std::vector<MapSource>& sources() const { return sources_; }
  void setSources(std::vector<MapSource> sources) { sources_ = std::move(sources); }

  /// D of its primitives, places or tasks; 0 if none of them has an embedding.
  Eigen::Index embeddingSize() const;

 private:
  std::string world_frame_;
  std::shared_ptr<const scene_graph::TaskList> object_tasks_;
  std::shared_ptr<const scene_graph::TaskList> place_tasks_;
  MapSettings settings_;
  std::vector<ObjectPrimitivePtr> primitives_;
  PlaceGraphPtr places_;
  std::vector<scene_graph::ObjectCluster> object_clusters_;
  std::vector<scene_graph::RegionCluster> region_clusters_;
  std::vector<mapping::BlockMesh> mesh_blocks_;
  double mesh_voxel_size_m_ = 0.0;
  std::shared_ptr<const Trajectory> trajectory_;
  std::shared_ptr<const places::PlaceMemory> place_memory_;
  std::shared_ptr<const mapping::OccupancyMap> occupancy_;
  std::vector<MapSource> sources_;
};

/// The map of what a builder was given: frame, tasks, configuration, primitives, places, and how
/// they are clustered now. Mesh, trajectory and the other settings are the caller's to add.
Map makeMap(scene_graph::SceneGraphBuilder& builder);

/// The scene graph that follows from a map: of a map by makeMap() the same, to the bit, as the
/// builder's own snapshot. O((primitives + places) * D) and the search of PointIndex.
/// @throws std::invalid_argument naming a member of a cluster that is not in the map, or whose
/// embedding is of another size than the tasks'.
scene_graph::SceneGraph computeSceneGraph(const Map& map);

/// Gives a builder what a map holds: its primitives, places and the ids of its clusters, in the
/// place of what it had; tasks and configuration stay. Primitives that do not fit the tasks are
/// left out. @returns what became of the primitives.
/// @throws std::invalid_argument as SceneGraphBuilder::setPlaces(); nothing has changed then.
scene_graph::PrimitiveUpdate restoreBuilder(const Map& map,
                                            scene_graph::SceneGraphBuilder& builder);

/// The mesh of all blocks, welded across their borders; world frame.
Mesh computeMesh(const Map& map);

}  // namespace tsg::map
