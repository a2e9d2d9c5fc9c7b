// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/concept_graphs.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "point_cloud.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/rotated_box.h"

namespace tsg::evaluation {
namespace {

constexpr std::size_t kFewestPoints = 16;  // of a detection
constexpr std::size_t kFewestLeft = 4;     // after a cleaning
constexpr double kLeastVolume_m3 = 1e-6;
constexpr double kThinnestSide_m = 0.02;
constexpr double kLeastIou = 1e-6;

std::vector<PointCloud> unproject(const RgbdFrame& frame, const Segmentation& segmentation) {
  std::vector<PointCloud> clouds_m(segmentation.numSegments());
  for (int v = 0; v < segmentation.labels.rows; ++v) {
    const auto* row = segmentation.labels.ptr<std::uint16_t>(v);
    for (int u = 0; u < segmentation.labels.cols; ++u) {
      const float depth_m = row[u] == 0 ? 0.0F : frame.depth.at(u, v);
      if (!(depth_m > 0.0F)) continue;
      const Eigen::Vector3d p_camera = frame.camera.unproject(u, v, static_cast<double>(depth_m));
      clouds_m[row[u] - 1U].emplace_back((frame.T_world_camera * p_camera).cast<float>());
    }
  }
  return clouds_m;
}

std::vector<int> countPixels(const Segmentation& segmentation) {
  std::vector<int> pixels(segmentation.numSegments(), 0);
  for (int v = 0; v < segmentation.labels.rows; ++v) {
    const auto* row = segmentation.labels.ptr<std::uint16_t>(v);
    for (int u = 0; u < segmentation.labels.cols; ++u) {
      if (row[u] > 0) ++pixels[row[u] - 1U];
    }
  }
  return pixels;
}

RotatedBox thicken(const OrientedBox& box) {
  RotatedBox thick = toRotatedBox(box);
  thick.size_m = thick.size_m.cwiseMax(kThinnestSide_m);
  return thick;
}

bool mayShareSpace(const OrientedBox& a, const OrientedBox& b) {
  const double reach_m =
      (a.size_m.cwiseMax(kThinnestSide_m).norm() + b.size_m.cwiseMax(kThinnestSide_m).norm()) / 2.0;
  return (a.center_m - b.center_m).squaredNorm() <= reach_m * reach_m &&
         computeIou(thicken(a), thicken(b)) >= kLeastIou;
}

}  // namespace

ConceptGraphs::ConceptGraphs(const ConceptGraphsConfig& config) : config_(config) {
  config::validate(config, "concept graphs");
}

std::vector<ConceptObject> ConceptGraphs::findDetections(const RgbdFrame& frame,
                                                         const Segmentation& segmentation) const {
  const std::vector<int> pixels = countPixels(segmentation);
  const double max_pixels =
      config_.max_image_share * static_cast<double>(segmentation.labels.total());
  std::vector<PointCloud> clouds_m = unproject(frame, segmentation);
  std::vector<ConceptObject> detections;
  for (std::size_t i = 0; i < clouds_m.size(); ++i) {
    const bool has_size = pixels[i] >= config_.min_pixels && pixels[i] <= max_pixels;
    const Embedding embedding =
        segmentation.embeddings.row(static_cast<Eigen::Index>(i)).transpose();
    if (!has_size || embedding.isZero(0.0F) || clouds_m[i].size() < kFewestPoints) continue;
    ConceptObject detection;
    detection.points_m =
        keepLargestCluster(downsample(clouds_m[i], config_.voxel_size_m), config_.cluster_radius_m,
                           static_cast<std::size_t>(config_.cluster_min_points));
    detection.box = computeOrientedBox(detection.points_m);
    detection.embedding = embedding.normalized();
    detection.num_detections = 1;
    detection.first_seen = detection.last_seen = frame.stamp;
    if (detection.box.volume() >= kLeastVolume_m3) detections.push_back(std::move(detection));
  }
  return detections;
}

std::size_t ConceptGraphs::findObject(const ConceptObject& detection, std::size_t count) const {
  std::size_t best = count;
  double highest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    const ConceptObject& object = objects_[i];
    const double overlap =
        mayShareSpace(detection.box, object.box)
            ? computeOverlap(detection.points_m, object.points_m, config_.voxel_size_m)
            : 0.0;
    const double cosine = static_cast<double>(detection.embedding.dot(object.embedding));
    const double similarity = overlap + cosine;
    if (similarity < config_.min_similarity || similarity <= highest) continue;
    highest = similarity;
    best = i;
  }
  return best;
}

void ConceptGraphs::fuse(const ConceptObject& from, ConceptObject& to) const {
  to.points_m.insert(to.points_m.end(), from.points_m.begin(), from.points_m.end());
  to.points_m = downsample(to.points_m, config_.voxel_size_m);
  to.box = computeOrientedBox(to.points_m);
  to.embedding = (static_cast<float>(to.num_detections) * to.embedding +
                  static_cast<float>(from.num_detections) * from.embedding)
                     .normalized();
  to.num_detections += from.num_detections;
  to.first_seen = std::min(to.first_seen, from.first_seen);
  to.last_seen = std::max(to.last_seen, from.last_seen);
}

void ConceptGraphs::denoise(ConceptObject& object) const {
  PointCloud cleaned_m = keepLargestCluster(downsample(object.points_m, config_.voxel_size_m),
                                            config_.cluster_radius_m,
                                            static_cast<std::size_t>(config_.cluster_min_points));
  if (cleaned_m.size() < kFewestLeft) return;
  object.points_m = std::move(cleaned_m);
  object.box = computeOrientedBox(object.points_m);
}

void ConceptGraphs::denoiseAll() {
  for (ConceptObject& object : objects_) denoise(object);
}

// The overlaps are those of before; an object that is gone may still be added to another one.
void ConceptGraphs::mergeOverlapping() {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;  // -overlap, from, to
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    for (std::size_t j = 0; j < objects_.size(); ++j) {
      if (i == j || !mayShareSpace(objects_[i].box, objects_[j].box)) continue;
      const double overlap =
          computeOverlap(objects_[i].points_m, objects_[j].points_m, config_.voxel_size_m);
      if (overlap > config_.merge_overlap) pairs.emplace_back(-overlap, i, j);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<bool> is_kept(objects_.size(), true);
  for (const auto& [overlap, from, to] : pairs) {
    const auto cosine = static_cast<double>(objects_[from].embedding.dot(objects_[to].embedding));
    if (!(cosine > config_.merge_cosine) || !is_kept[to]) continue;
    fuse(objects_[from], objects_[to]);
    denoise(objects_[to]);
    is_kept[from] = false;
  }
  std::vector<ConceptObject> kept;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (is_kept[i]) kept.push_back(std::move(objects_[i]));
  }
  objects_ = std::move(kept);
}

void ConceptGraphs::add(const RgbdFrame& frame, const Segmentation& segmentation) {
  ++num_frames_;
  const std::vector<ConceptObject> detections = findDetections(frame, segmentation);
  if (detections.empty()) return;  // such a frame counts, but cleans nothing up
  // All detections are compared with the objects of before this frame.
  const std::size_t count = objects_.size();
  std::vector<std::size_t> targets;
  for (const ConceptObject& detection : detections) {
    targets.push_back(findObject(detection, count));
  }
  for (std::size_t i = 0; i < detections.size(); ++i) {
    if (targets[i] == count) {
      objects_.push_back(detections[i]);
    } else {
      fuse(detections[i], objects_[targets[i]]);
    }
  }
  if (config_.denoise_interval > 0 && num_frames_ % config_.denoise_interval == 0) denoiseAll();
  if (config_.merge_interval > 0 && num_frames_ % config_.merge_interval == 0) mergeOverlapping();
}

std::vector<ConceptObject> ConceptGraphs::finish() {
  denoiseAll();
  const auto is_rare = [&](const ConceptObject& object) {
    return object.num_detections < static_cast<std::size_t>(config_.min_detections);
  };
  objects_.erase(std::remove_if(objects_.begin(), objects_.end(), is_rare), objects_.end());
  mergeOverlapping();
  return objects_;
}

}  // namespace tsg::evaluation
