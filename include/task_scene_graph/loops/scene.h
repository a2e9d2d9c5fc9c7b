// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/loops/constellation.h"
#include "task_scene_graph/loops/local_cloud.h"
#include "task_scene_graph/loops/visibility.h"

namespace tsg::loops {

struct SceneConfig {
  double max_range_m = 5.0;
  double voxel_m = 0.1;
  double join_radius_m = 0.3;
  double max_landmark_m = 1.5;
  int min_pixels = 50;
  int view_cells = 40;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("max_range_m", self.max_range_m, {0.5, 100.0}, "m", "depth is used up to this");
    v.field("voxel_m", self.voxel_m, {0.01, 1.0}, "m",
            "points of the local cloud are so far apart");
    v.field("join_radius_m", self.join_radius_m, {0.01, 5.0}, "m",
            "what looks alike so near to each other is one landmark");
    v.field("max_landmark_m", self.max_landmark_m, {0.1, 100.0}, "m",
            "segments that are larger have no middle to speak of");
    v.field("view_cells", self.view_cells, {4.0, 1000.0}, "",
            "an image's width is kept in so many cells: how far space was free");
    v.field("min_pixels", self.min_pixels, {1.0, 1e6}, "px", "with depth; of a landmark's segment");
  }
};

/// What a keyframe, or several around an anchor, show: in the frame of that keyframe's camera.
struct Scene {
  Points points;
  std::vector<DepthView> views;
  std::vector<Landmark> landmarks;
  Embedding image;  ///< empty if there is none
};

/// Segments with an embedding, by the mean of their points with depth in range; not those that the
/// image's border cuts, which have another middle in each view. In the camera's frame. O(pixels).
/// @param segmentation  aligned to the frame, alignToFrame()
std::vector<Landmark> makeLandmarks(const RgbdFrame& frame, const Segmentation& segmentation,
                                    const SceneConfig& config);

/// @param segmentation  as published; may be null: then points only
Scene makeScene(const RgbdFrame& frame, const SegmentationPtr& segmentation,
                const SceneConfig& config);

/// Sum of scenes: points and landmarks brought to one frame, embeddings averaged.
/// @param parts  poses T_anchor_part, and scenes
Scene joinScenes(const std::vector<std::pair<Pose, const Scene*>>& parts, const SceneConfig& config,
                 double min_cosine);

}  // namespace tsg::loops
