// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "task_scene_graph/core/stage_times.h"
#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/map/map.h"
#include "task_scene_graph/pipeline/background_fusion.h"
#include "task_scene_graph/pipeline/object_fusion.h"
#include "task_scene_graph/places/place_extractor.h"
#include "task_scene_graph/scene_graph/builder.h"
#include "task_scene_graph/segmentation/segmenter.h"
#include "task_scene_graph/tracking/tracker.h"

namespace tsg::pipeline {

struct MeshFusionConfig {
  BackgroundFusionConfig background_fusion;
  ObjectFusionConfig object_fusion;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    BackgroundFusionConfig::visit(self.background_fusion, v);
    ObjectFusionConfig::visit(self.object_fusion, v);
  }
};

/// One section per stage, named like its nodelet: the layout of config/default.yaml.
struct PipelineConfig {
  segmentation::SegmenterConfig segmenter;
  tracking::TrackerConfig tracker;
  MeshFusionConfig mesh_fusion;
  scene_graph::SceneGraphConfig scene_graph;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.group("segmenter", self.segmenter);
    v.group("tracker", self.tracker);
    v.group("mesh_fusion", self.mesh_fusion);
    v.group("scene_graph", self.scene_graph);
  }
};

/// The whole chain [Clio24, Fig. 3] in one thread, every frame in order: what the nodelets do,
/// without a clock. The result depends on the frames only, not on time or the number of threads.
class Pipeline {
 public:
  /// @param segmenter  may be null: only recorded segmentations are used then.
  /// @param world_frame  name of the frame that the frames' poses map to
  /// @throws config::ConfigError, or std::invalid_argument for unusable tasks.
  Pipeline(const PipelineConfig& config, const scene_graph::TaskList& object_tasks,
           const scene_graph::TaskList& place_tasks,
           std::unique_ptr<segmentation::Segmenter> segmenter,
           const std::string& world_frame = "world");

  /// Goes on from a map of before: its primitives, places, mesh, trajectory and ids. Tasks and
  /// configuration stay. Before the first frame.
  /// @throws std::invalid_argument naming both if a voxel size is another than the configuration's.
  void restore(const map::Map& map);

  /// @param recorded  segmentation of this frame, or null: the segmenter is asked, if there is one.
  void process(const RgbdFramePtr& frame, const SegmentationPtr& recorded);

  /// Ends all tracks, updates the places and returns the map. Frames may follow.
  map::MapPtr finish();

  /// Null unless mesh_fusion/occupancy/enabled.
  const mapping::OccupancyMap* occupancy() const { return occupancy_.get(); }
  const StageTimes& times() const { return times_; }
  const ObjectFusion& objects() const { return objects_; }
  const BackgroundFusion& background() const { return background_; }
  const places::PlaceExtractor& places() const { return places_; }
  const tracking::Tracker& tracker() const { return tracker_; }
  const scene_graph::SceneGraphBuilder& sceneGraph() const { return scene_graph_; }

 private:
  SegmentationPtr findSegmentation(const RgbdFrame& frame, const SegmentationPtr& recorded);
  void integrate(const RgbdFrame& frame);
  void addTracks(const TrackedFrame& tracked);
  void updatePlaces(bool force);
  std::vector<mapping::BlockMesh> updateMesh();

  std::unique_ptr<segmentation::Segmenter> segmenter_;
  tracking::Tracker tracker_;
  BackgroundFusion background_;
  std::unique_ptr<mapping::OccupancyMap> occupancy_;
  places::PlaceExtractor places_;
  double places_period_s_;
  std::optional<Stamp> last_places_;
  ObjectFusion objects_;
  scene_graph::SceneGraphBuilder scene_graph_;
  Trajectory trajectory_;
  std::vector<map::MapSource> sources_;
  StageTimes times_;
  Stamp newest_;
};

}  // namespace tsg::pipeline
