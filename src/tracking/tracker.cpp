// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/tracking/association.h"

namespace tsg::tracking {
namespace {

// Bounds of FeatureWeight: no view is worth nothing, none infinitely much.
constexpr double kMinFrontality = 0.1;
constexpr double kMinDistance_m = 0.3;

bool hasSize(const cv::Mat& image, const CameraModel& camera) {
  return image.cols == camera.width_px && image.rows == camera.height_px;
}

bool hasDepth(const RgbdFrame& frame) {
  const int type = frame.depth.image.type();
  return (type == CV_16UC1 || type == CV_32FC1) && hasSize(frame.depth.image, frame.camera);
}

bool hasLabels(const Segmentation& segmentation, const CameraModel& camera) {
  if (segmentation.labels.type() != CV_16UC1 || !hasSize(segmentation.labels, camera)) return false;
  double largest = 0.0;
  cv::minMaxIdx(segmentation.labels, nullptr, &largest);
  return largest <= static_cast<double>(segmentation.numSegments());
}

/// True if every point within range has voxel coordinates that fit a key.
bool isInGrid(const Pose& T_world_camera, const TrackerConfig& config) {
  const double limit_m = kVoxelLimit * config.voxel_size_m - 2.0 * config.max_range_m;
  return T_world_camera.matrix().allFinite() &&
         (T_world_camera.translation().array().abs() < limit_m).all();
}

}  // namespace

AssociationThresholds resolveThresholds(const TrackerConfig& config) {
  AssociationThresholds thresholds = config.preset == Preset::kClio
                                         ? AssociationThresholds{0.9, 0.6}
                                         : AssociationThresholds{0.7, 0.4};
  if (config.min_cosine > TrackerConfig::kFromPreset) thresholds.min_cosine = config.min_cosine;
  if (config.min_iou >= 0.0) thresholds.min_iou = config.min_iou;
  return thresholds;
}

void CosineHistogram::add(double cosine) {
  const double share = std::clamp(0.5 * (cosine + 1.0), 0.0, 1.0);
  const auto bin = static_cast<std::size_t>(share * static_cast<double>(kBins));
  ++counts_[std::min(bin, kBins - 1)];
}

std::uint64_t CosineHistogram::count() const {
  return std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
}

double CosineHistogram::quantile(double share) const {
  const double rank = share * static_cast<double>(count());
  double below = 0.0;
  for (std::size_t i = 0; i < kBins; ++i) {
    below += static_cast<double>(counts_[i]);
    if (below > 0.0 && below >= rank) {
      return 2.0 * (static_cast<double>(i) + 0.5) / static_cast<double>(kBins) - 1.0;
    }
  }
  return 0.0;
}

double ViewCosine::computeLimit(double configured) const {
  if (cosines_.count() < kLeastPairs) return configured;
  constexpr double kQuartile = 0.6745;  // of a normal distribution, in standard deviations
  const double median = cosines_.quantile(0.5);
  const double deviation = (median - cosines_.quantile(0.25)) / kQuartile;
  return std::min(configured, std::max(kLeastCosine, median - 3.0 * deviation));
}

Tracker::Tracker(const TrackerConfig& config)
    : config_(config), thresholds_(resolveThresholds(config)) {
  config::validate(config, "tracker");
  counters_.min_cosine = thresholds_.min_cosine;
}

bool Tracker::isUsable(const RgbdFrame& frame, const Segmentation& segmentation) const {
  const Eigen::Index size = segmentation.embeddings.cols();
  const bool fits = embedding_size_ == 0 || size == 0 || size == embedding_size_;
  return frame.stamp == segmentation.stamp && fits && segmentation.embeddings.allFinite() &&
         hasDepth(frame) && isInGrid(frame.T_world_camera, config_) &&
         hasLabels(segmentation, frame.camera);
}

TrackedFrame Tracker::makeIgnored(Stamp stamp, const Segmentation& segmentation) const {
  TrackedFrame ignored;
  ignored.stamp = stamp;
  ignored.segment_tracks.resize(segmentation.numSegments());
  ignored.live = liveIds();
  return ignored;
}

TrackedFrame Tracker::update(const RgbdFrame& frame, const Segmentation& segmentation) {
  ++counters_.frames;
  if (has_stamp_ && frame.stamp <= last_stamp_) {
    ++counters_.out_of_order_frames;
    return makeIgnored(frame.stamp, segmentation);
  }
  if (!isUsable(frame, segmentation)) {
    ++counters_.invalid_frames;
    return makeIgnored(frame.stamp, segmentation);
  }
  has_stamp_ = true;
  last_stamp_ = frame.stamp;
  embedding_size_ = std::max(embedding_size_, segmentation.embeddings.cols());

  TrackedFrame result = makeIgnored(frame.stamp, segmentation);
  result.finished = endTracks(frame.stamp, config_.window_s);
  FrameSegments segments{segmentation, frame.T_world_camera.translation(), {}, {}, {}};
  segments.points = computeSegmentPoints(frame, segmentation.labels, segmentation.numSegments(),
                                         {config_.voxel_size_m, config_.max_range_m});
  segments.is_selected = selectSegments(segments.points, segmentation.labels.total());
  segments.is_cut = findCutSegments(segmentation.labels, segmentation.numSegments());
  const std::vector<Overlap> overlaps = findOverlaps(segments);
  countCosines(overlaps);
  associate(assignGreedily(findCandidates(overlaps)), segments, result);
  if (adaptsCosine()) learnCosine(overlaps);
  openTracks(segments, result);
  result.live = liveIds();
  return result;
}

TrackedFrame Tracker::finish() {
  TrackedFrame result;
  result.stamp = last_stamp_;
  result.finished = endTracks(last_stamp_, -std::numeric_limits<double>::infinity());
  return result;
}

std::vector<Track> Tracker::describeLiveTracks(bool all) {
  const std::size_t min_observations =
      std::max(kMinDescribed, static_cast<std::size_t>(config_.min_observations));
  std::vector<Track> tracks;
  for (LiveTrack& live : live_) {
    const std::size_t size = live.track.observations.size();
    const bool has_grown = size >= kGrowth * live.num_described;
    if (size < min_observations || !(all || has_grown)) continue;
    live.num_described = size;
    tracks.push_back(live.track);
    tracks.back().embedding = live.mean;
    tracks.back().views = live.views.statistics();
  }
  return tracks;
}

std::vector<bool> Tracker::selectSegments(const std::vector<SegmentPoints>& segments,
                                          std::size_t image_pixels) {
  const double max_pixels = config_.max_image_share * static_cast<double>(image_pixels);
  std::vector<bool> is_selected(segments.size());
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const bool is_small = segments[s].pixels < static_cast<std::size_t>(config_.min_pixels);
    const bool is_large = static_cast<double>(segments[s].pixels) > max_pixels;
    counters_.small_segments += is_small ? 1 : 0;
    counters_.large_segments += is_large && !is_small ? 1 : 0;
    is_selected[s] = !is_small && !is_large;
  }
  counters_.segments += segments.size();
  return is_selected;
}

bool Tracker::adaptsCosine() const {
  return config_.adapt_cosine && config_.min_cosine == TrackerConfig::kFromPreset;
}

std::vector<Tracker::Overlap> Tracker::findOverlaps(const FrameSegments& segments) const {
  std::vector<Overlap> overlaps;
  for (std::size_t s = 0; s < segments.points.size(); ++s) {
    if (segments.is_selected[s]) addOverlaps(segments, s, overlaps);
  }
  return overlaps;
}

void Tracker::addOverlaps(const FrameSegments& segments, std::size_t segment,
                          std::vector<Overlap>& overlaps) const {
  const VoxelSet& voxels = segments.points[segment].voxels;
  const auto embedding =
      segments.segmentation.embeddings.row(static_cast<Eigen::Index>(segment)).transpose();
  const bool has_embedding = embedding.size() > 0 && !embedding.isZero(0.0F);
  for (std::size_t t = 0; t < live_.size(); ++t) {
    const LiveTrack& track = live_[t];
    if (!mayReachIoU(voxels, track.last_voxels, thresholds_.min_iou)) continue;
    const double iou = computeIoU(voxels, track.last_voxels);
    if (!(iou > 0.0 && iou >= thresholds_.min_iou)) continue;
    Overlap overlap{{segment, t, iou}, {}};
    if (has_embedding && track.mean.size() > 0) {
      overlap.cosine = computeCosine(embedding, track.mean);
    }
    overlaps.push_back(overlap);
  }
}

std::vector<Candidate> Tracker::findCandidates(const std::vector<Overlap>& overlaps) const {
  std::vector<Candidate> candidates;
  for (const Overlap& overlap : overlaps) {
    if (overlap.cosine.value_or(1.0) >= counters_.min_cosine) candidates.push_back(overlap.pair);
  }
  return candidates;
}

// Overlaps of one segment stand together.
void Tracker::countCosines(const std::vector<Overlap>& overlaps) {
  for (auto begin = overlaps.begin(); begin != overlaps.end();) {
    const Overlap* best = nullptr;
    bool is_refused = true;
    auto end = begin;
    for (; end != overlaps.end() && end->pair.segment == begin->pair.segment; ++end) {
      is_refused = is_refused && end->cosine.value_or(1.0) < counters_.min_cosine;
      if (end->cosine && (best == nullptr || end->pair.iou > best->pair.iou)) best = &*end;
    }
    begin = end;
    if (best == nullptr) continue;
    ++counters_.overlapping_segments;
    counters_.refused_by_cosine += is_refused ? 1 : 0;
    counters_.overlap_cosines.add(*best->cosine);
  }
}

// Settled: of all pairs the first to be assigned if cosines did not count, and by far.
void Tracker::learnCosine(const std::vector<Overlap>& overlaps) {
  std::vector<Candidate> pairs;
  std::map<std::pair<std::size_t, std::size_t>, double> cosines;
  for (const Overlap& overlap : overlaps) {
    pairs.push_back(overlap.pair);
    if (overlap.cosine) cosines[{overlap.pair.segment, overlap.pair.track}] = *overlap.cosine;
  }
  for (const Candidate& pair : assignGreedily(std::move(pairs))) {
    const auto cosine = cosines.find({pair.segment, pair.track});
    if (pair.iou >= ViewCosine::kLeastIou && cosine != cosines.end()) {
      view_cosine_.add(cosine->second);
    }
  }
  counters_.min_cosine = view_cosine_.computeLimit(thresholds_.min_cosine);
}

void Tracker::associate(const std::vector<Candidate>& matches, FrameSegments& segments,
                        TrackedFrame& result) {
  for (const Candidate& match : matches) {
    LiveTrack& track = live_[match.track];
    observe(track, match.segment, segments);
    result.segment_tracks[match.segment] = track.track.id;
  }
  counters_.associations += matches.size();
}

void Tracker::openTracks(FrameSegments& segments, TrackedFrame& result) {
  for (std::size_t s = 0; s < segments.points.size(); ++s) {
    if (!segments.is_selected[s] || result.segment_tracks[s].isValid()) continue;
    LiveTrack track;
    track.track.id = TrackId{next_id_++};
    track.track.first_seen = segments.segmentation.stamp;
    observe(track, s, segments);
    result.segment_tracks[s] = track.track.id;
    live_.push_back(std::move(track));
    ++counters_.tracks_started;
  }
}

void Tracker::observe(LiveTrack& track, std::size_t segment, FrameSegments& segments) {
  SegmentPoints& points = segments.points[segment];
  const SegmentView view =
      computeSegmentView(points.voxels, config_.voxel_size_m, segments.camera_m);
  const Observation observation{segments.segmentation.stamp,
                                static_cast<std::uint16_t>(segment + 1)};
  track.track.last_seen = observation.stamp;
  track.track.observations.push_back(observation);
  track.views.add(observation, view, points.pixels, segments.is_cut[segment]);
  track.last_voxels = std::move(points.voxels);
  const auto embedding =
      segments.segmentation.embeddings.row(static_cast<Eigen::Index>(segment)).transpose();
  if (embedding.size() == 0 || embedding.isZero(0.0F)) return;
  const double weight = computeFeatureWeight(view, points.pixels);
  if (track.feature_sum.size() == 0) track.feature_sum.setZero(embedding.size());
  track.feature_sum += weight * embedding.cast<double>();
  track.feature_weight += weight;
  track.mean = (track.feature_sum / track.feature_weight).cast<float>();
}

double Tracker::computeFeatureWeight(const SegmentView& view, std::size_t pixels) const {
  switch (config_.feature_weight) {
    case FeatureWeight::kPixels:
      return static_cast<double>(pixels);
    case FeatureWeight::kViewAngle:
      return std::max(kMinFrontality, view.frontality);
    case FeatureWeight::kDistance:
      return 1.0 / std::pow(std::max(kMinDistance_m, view.distance_m), 2);
    case FeatureWeight::kEqual:
      break;
  }
  return 1.0;
}

std::vector<Track> Tracker::endTracks(Stamp now, double window_s) {
  const auto has_ended = [&](const LiveTrack& live) {
    return secondsBetween(live.track.last_seen, now) > window_s;
  };
  std::vector<Track> finished;
  for (LiveTrack& live : live_) {
    if (!has_ended(live)) continue;
    if (static_cast<int>(live.track.observations.size()) < config_.min_observations) {
      ++counters_.tracks_dropped;
      continue;
    }
    live.track.embedding = std::move(live.mean);
    live.track.views = live.views.statistics();
    finished.push_back(std::move(live.track));
    ++counters_.tracks_finished;
  }
  live_.erase(std::remove_if(live_.begin(), live_.end(), has_ended), live_.end());
  return finished;
}

std::vector<TrackId> Tracker::liveIds() const {
  std::vector<TrackId> ids;
  ids.reserve(live_.size());
  for (const LiveTrack& live : live_) ids.push_back(live.track.id);
  return ids;
}

}  // namespace tsg::tracking
