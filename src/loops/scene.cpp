// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

namespace tsg::loops {
namespace {

struct Segment {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  Eigen::AlignedBox3d box;
  int count = 0;
  bool is_cut = false;
};

std::vector<Segment> collectSegments(const RgbdFrame& frame, const Segmentation& segmentation,
                                     double max_range_m) {
  std::vector<Segment> segments(segmentation.numSegments());
  const cv::Size size = segmentation.labels.size();
  for (int v = 0; v < size.height; ++v) {
    const auto* labels = segmentation.labels.ptr<std::uint16_t>(v);
    for (int u = 0; u < size.width; ++u) {
      if (labels[u] == 0) continue;
      Segment& segment = segments[labels[u] - 1U];
      if (u == 0 || v == 0 || u + 1 == size.width || v + 1 == size.height) segment.is_cut = true;
      const double z_m = static_cast<double>(frame.depth.at(u, v));
      if (z_m <= 0.0 || z_m > max_range_m) continue;
      const Eigen::Vector3d p = frame.camera.unproject(u, v, z_m);
      segment.sum_m += p;
      segment.box.extend(p);
      ++segment.count;
    }
  }
  return segments;
}

}  // namespace

std::vector<Landmark> makeLandmarks(const RgbdFrame& frame, const Segmentation& segmentation,
                                    const SceneConfig& config) {
  const auto segments = collectSegments(frame, segmentation, config.max_range_m);
  std::vector<Landmark> landmarks;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const Segment& segment = segments[s];
    if (segment.is_cut || segment.count < config.min_pixels) continue;
    if (segment.box.sizes().maxCoeff() > config.max_landmark_m) continue;
    const Embedding embedding = segmentation.embeddings.row(static_cast<Eigen::Index>(s));
    if (!(embedding.squaredNorm() > 0.0F)) continue;
    landmarks.push_back({segment.sum_m / segment.count, embedding});
  }
  return landmarks;
}

Scene makeScene(const RgbdFrame& frame, const SegmentationPtr& segmentation,
                const SceneConfig& config) {
  Scene scene;
  scene.points = makeCloud(frame.depth, frame.camera, static_cast<float>(config.voxel_m),
                           static_cast<float>(config.max_range_m));
  const int cell_px = std::max(1, frame.camera.width_px / config.view_cells);
  scene.views.push_back(makeDepthView(frame.depth, frame.camera, cell_px));
  if (!segmentation) return scene;
  scene.landmarks = makeLandmarks(frame, *alignToFrame(frame, segmentation), config);
  scene.image = segmentation->image_embedding;
  return scene;
}

Scene joinScenes(const std::vector<std::pair<Pose, const Scene*>>& parts, const SceneConfig& config,
                 double min_cosine) {
  Scene joined;
  for (const auto& [T_anchor_part, part] : parts) {
    const Points points = transform(T_anchor_part, part->points);
    joined.points.insert(joined.points.end(), points.begin(), points.end());
    for (DepthView view : part->views) {
      view.T_scene_camera = T_anchor_part * view.T_scene_camera;
      joined.views.push_back(std::move(view));
    }
    std::vector<Landmark> landmarks = part->landmarks;
    for (Landmark& landmark : landmarks) landmark.position_m = T_anchor_part * landmark.position_m;
    joinLandmarks(landmarks, config.join_radius_m, min_cosine, joined.landmarks);
    if (part->image.size() == 0) continue;
    if (joined.image.size() == 0) joined.image = Embedding::Zero(part->image.size());
    if (joined.image.size() == part->image.size()) joined.image += part->image.normalized();
  }
  joined.points = downsample(joined.points, static_cast<float>(config.voxel_m));
  return joined;
}

}  // namespace tsg::loops
