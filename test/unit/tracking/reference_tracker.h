// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "task_scene_graph/tracking/tracker.h"

namespace tsg::tracking::test {

using Voxel = std::tuple<int, int, int>;

/// Straight from the definition: every pixel unprojected with the camera's own function.
inline std::vector<std::set<Voxel>> computeVoxelsSlowly(const RgbdFrame& frame,
                                                        const cv::Mat& labels,
                                                        std::size_t num_segments,
                                                        const PixelFilter& filter) {
  std::vector<std::set<Voxel>> segments(num_segments);
  for (int v = 0; v < labels.rows; ++v) {
    for (int u = 0; u < labels.cols; ++u) {
      const int label = labels.at<std::uint16_t>(v, u);
      const double z_m = static_cast<double>(frame.depth.at(u, v));
      const Eigen::Vector3d p_camera = frame.camera.unproject(u, v, z_m);
      if (label == 0 || z_m == 0.0 || p_camera.norm() > filter.max_range_m) continue;
      const Eigen::Vector3d p_world = frame.T_world_camera * p_camera / filter.voxel_size_m;
      const Eigen::Vector3i voxel = p_world.array().floor().cast<int>();
      segments[static_cast<std::size_t>(label) - 1].insert({voxel.x(), voxel.y(), voxel.z()});
    }
  }
  return segments;
}

inline double computeIoUBySets(const std::set<Voxel>& a, const std::set<Voxel>& b) {
  std::set<Voxel> united = a;
  united.insert(b.begin(), b.end());
  std::size_t shared = 0;
  for (const Voxel& voxel : a) shared += b.count(voxel);
  return united.empty() ? 0.0 : static_cast<double>(shared) / static_cast<double>(united.size());
}

/// The paper's association written down without regard to cost: no prefilter, all embeddings kept.
class ReferenceTracker {
 public:
  struct Entry {
    std::vector<Embedding> embeddings;
    std::set<Voxel> voxels;
    Stamp first_seen;
    Stamp last_seen;
    std::vector<Observation> observations;
  };

  explicit ReferenceTracker(const TrackerConfig& config) : config_(config) {}

  std::map<std::uint64_t, Entry> live;
  std::map<std::uint64_t, Entry> ended;

  /// Track of each segment; segments must all have enough pixels.
  std::vector<std::uint64_t> update(const RgbdFrame& frame, const Segmentation& segmentation) {
    endOld(frame.stamp);
    const auto voxels = computeVoxelsSlowly(frame, segmentation.labels, segmentation.numSegments(),
                                            {config_.voxel_size_m, config_.max_range_m});
    std::vector<std::uint64_t> tracks(voxels.size(), 0);
    while (assignBest(voxels, segmentation, tracks)) {
    }
    for (std::size_t s = 0; s < voxels.size(); ++s) {
      if (tracks[s] == 0) tracks[s] = ++last_id_;
      record(live[tracks[s]], s, voxels[s], segmentation);
    }
    return tracks;
  }

  static Embedding computeMean(const Entry& entry) {
    if (entry.embeddings.empty()) return {};
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(entry.embeddings[0].size());
    for (const Embedding& embedding : entry.embeddings) sum += embedding.cast<double>();
    return (sum / static_cast<double>(entry.embeddings.size())).cast<float>();
  }

 private:
  void endOld(Stamp now) {
    for (auto it = live.begin(); it != live.end();) {
      const bool has_ended = now.seconds() - it->second.last_seen.seconds() > config_.window_s;
      if (has_ended) ended.insert(*it);
      it = has_ended ? live.erase(it) : std::next(it);
    }
  }

  bool isCandidate(const Entry& entry, const Embedding& embedding, double iou) const {
    const auto thresholds = resolveThresholds(config_);
    const Embedding mean = computeMean(entry);
    const bool is_comparable = mean.size() > 0 && embedding.squaredNorm() > 0.0F;
    const bool is_similar =
        !is_comparable || computeCosine(mean, embedding) >= thresholds.min_cosine;
    return is_similar && iou > 0.0 && iou >= thresholds.min_iou;
  }

  bool assignBest(const std::vector<std::set<Voxel>>& voxels, const Segmentation& segmentation,
                  std::vector<std::uint64_t>& tracks) const {
    std::tuple<double, std::uint64_t, std::size_t> best{1.0, 0, 0};  // -IoU, track, segment
    for (std::size_t s = 0; s < voxels.size(); ++s) {
      if (tracks[s] != 0) continue;
      const Embedding embedding = segmentation.embeddings.row(static_cast<int>(s));
      for (const auto& [id, entry] : live) {
        if (std::count(tracks.begin(), tracks.end(), id) > 0) continue;
        const double iou = computeIoUBySets(voxels[s], entry.voxels);
        if (isCandidate(entry, embedding, iou)) best = std::min(best, {-iou, id, s});
      }
    }
    if (std::get<1>(best) == 0) return false;
    tracks[std::get<2>(best)] = std::get<1>(best);
    return true;
  }

  static void record(Entry& entry, std::size_t s, const std::set<Voxel>& voxels,
                     const Segmentation& segmentation) {
    if (entry.observations.empty()) entry.first_seen = segmentation.stamp;
    entry.last_seen = segmentation.stamp;
    entry.voxels = voxels;
    entry.observations.push_back({segmentation.stamp, static_cast<std::uint16_t>(s + 1)});
    const Embedding embedding = segmentation.embeddings.row(static_cast<int>(s));
    if (embedding.squaredNorm() > 0.0F) entry.embeddings.push_back(embedding);
  }

  TrackerConfig config_;
  std::uint64_t last_id_ = 0;
};

}  // namespace tsg::tracking::test
