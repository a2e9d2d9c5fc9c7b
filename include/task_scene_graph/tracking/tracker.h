// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/tracking/association.h"
#include "task_scene_graph/tracking/segment_view.h"
#include "task_scene_graph/tracking/voxel_set.h"

namespace tsg::tracking {

/// Named pairs of thresholds (theta_track, gamma).
enum class Preset {
  kClio,    ///< 0.9, 0.6: fine segments
  kKhronos  ///< 0.7, 0.4: whole objects
};

/// What an observation counts in its track's mean embedding.
enum class FeatureWeight {
  kEqual,      ///< 1
  kPixels,     ///< its pixels with valid depth in range
  kViewAngle,  ///< max(0.1, frontality): cosine between line of sight and surface normal
  kDistance    ///< 1 / max(0.3, distance)^2, distances in metres
};

/// deviation: upstream drops segments of more than 50000 px, which at 640x480 is every object that
/// fills a sixth of the image; here the limit is a share of the image, and by default half of it.
struct TrackerConfig {
  static constexpr double kFromPreset = -1.0;

  Preset preset = Preset::kClio;
  double min_cosine = kFromPreset;
  double min_iou = kFromPreset;
  bool adapt_cosine = true;
  double window_s = 5.0;
  int min_observations = 2;
  FeatureWeight feature_weight = FeatureWeight::kEqual;
  double voxel_size_m = 0.1;
  double max_range_m = 8.0;
  int min_pixels = 20;
  double max_image_share = 0.5;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.choice("preset", self.preset, {{"clio", Preset::kClio}, {"khronos", Preset::kKhronos}},
             "thresholds: clio = cosine 0.9, IoU 0.6; khronos = cosine 0.7, IoU 0.4");
    v.field("min_cosine", self.min_cosine, {-1.0, 1.0}, "",
            "theta_track: least cosine of a segment and its track's mean; -1 = the preset's");
    v.field("min_iou", self.min_iou, {-1.0, 1.0}, "",
            "gamma: least voxel IoU with the track's last observation; negative = the preset's");
    v.field(
        "adapt_cosine", self.adapt_cosine, {}, "",
        "lowers the preset's cosine where views of one thing, as geometry tells, are less alike; a "
        "min_cosine that is given stays");
    v.field("window_s", self.window_s, {0.0, 600.0}, "s", "tau: a track unseen for longer ends");
    v.field("min_observations", self.min_observations, {1, 1000}, "",
            "ended tracks with fewer observations are dropped");
    v.choice("feature_weight", self.feature_weight,
             {{"equal", FeatureWeight::kEqual},
              {"pixels", FeatureWeight::kPixels},
              {"view_angle", FeatureWeight::kViewAngle},
              {"distance", FeatureWeight::kDistance}},
             "what an observation counts in its track's mean embedding: the same, its pixels, the "
             "cosine between line of sight and surface normal, or 1 / distance^2");
    v.field("voxel_size_m", self.voxel_size_m, {0.01, 1.0}, "m", "voxels of the 3D IoU");
    v.field("max_range_m", self.max_range_m, {0.1, 100.0}, "m",
            "points farther from the camera are ignored");
    v.field("min_pixels", self.min_pixels, {1, 1000000}, "px",
            "segments with fewer valid pixels within range are ignored");
    v.field("max_image_share", self.max_image_share, {0.0, 1.0}, "",
            "segments that cover more of the image are ignored");
  }
};

struct AssociationThresholds {
  double min_cosine = 0.0;
  double min_iou = 0.0;
};

/// The preset's thresholds with the configuration's own in their place where it gives any.
AssociationThresholds resolveThresholds(const TrackerConfig& config);

/// Cosines of segments to the means of the tracks that they overlap.
class CosineHistogram {
 public:
  void add(double cosine);
  std::uint64_t count() const;
  /// The cosine below which `share` of those added lie, right to 0.01; 0 if there is none.
  double quantile(double share) const;

 private:
  static constexpr std::size_t kBins = 200;  // of [-1, 1]
  std::array<std::uint64_t, kBins> counts_{};
};

/// Least cosine for views of one thing, learned from pairs of segment and track that geometry alone
/// settles: their median less three standard deviations, these told from the lower quartile, so
/// that pairs of different things among them (up to a quarter) do not count.
/// deviation: [Clio24] has a fixed threshold, which is compared with a mean of a single view as
/// well as of many; encoders whose views of one thing differ more than that lose all their tracks.
class ViewCosine {
 public:
  static constexpr std::uint64_t kLeastPairs = 30;  ///< with fewer nothing is known
  static constexpr double kLeastIou = 0.7;          ///< of a pair that geometry settles
  static constexpr double kLeastCosine = 0.4;       ///< what is learned is never lower

  void add(double cosine) { cosines_.add(cosine); }
  /// `configured`, or what was learned if that is lower.
  double computeLimit(double configured) const;

 private:
  CosineHistogram cosines_;
};

/// What a tracker has seen and done since it was made.
struct TrackerCounters {
  std::uint64_t frames = 0;               ///< given to update()
  std::uint64_t out_of_order_frames = 0;  ///< ignored: not later than the frame before
  std::uint64_t invalid_frames = 0;       ///< ignored: see Tracker::update
  std::uint64_t segments = 0;             ///< in frames that were not ignored
  std::uint64_t small_segments = 0;       ///< ignored: fewer valid pixels than min_pixels
  std::uint64_t large_segments = 0;       ///< ignored: share of the image above max_image_share
  std::uint64_t associations = 0;         ///< segments that continued a track
  std::uint64_t tracks_started = 0;
  std::uint64_t tracks_finished = 0;  ///< handed out
  std::uint64_t tracks_dropped = 0;   ///< ended with fewer than min_observations
  /// Segments with an embedding that overlap a live track with one by min_iou or more.
  std::uint64_t overlapping_segments = 0;
  std::uint64_t refused_by_cosine = 0;  ///< of these, less similar than min_cosine to each of them
  CosineHistogram overlap_cosines;      ///< of these, to the track that they overlap most
  double min_cosine = 0.0;              ///< in force: configured, or adapted
};

/// Associates the segments of successive frames with tracks [Clio24, Sec. IV-A]: a segment may
/// continue a track if the cosine of its embedding and the track's mean is >= min_cosine (which
/// ViewCosine lowers where it is the preset's and adapt_cosine allows) and the
/// IoU of its voxels with those of the track's last observation is >= min_iou (and above 0); the
/// highest IoU wins, one segment per track and frame (assignGreedily). Segments left over open
/// tracks, which are no candidates for their own frame. A segment or track without embedding is
/// judged by IoU alone, and such an observation does not enter the mean. Finished tracks say from
/// where they were seen (ViewStatistics). Not thread-safe.
/// deviation: upstream lets several segments join one track, takes the first track that passes, and
/// loses the first observation's embedding.
class Tracker {
 public:
  /// @throws config::ConfigError naming every field out of range.
  explicit Tracker(const TrackerConfig& config);

  /// Takes in one segmented frame; stamps must increase. A frame is ignored and counted, and the
  /// result then has no association and ends no track, if it is not later than the last one
  /// (out_of_order_frames) or (invalid_frames) its stamp differs from the segmentation's, sizes or
  /// types of label image, depth and camera disagree, the pose is not finite or out of the voxel
  /// grid (10^6 voxels), a label exceeds the number of segments, or an embedding is not finite or
  /// of another size than before. O(pixels + segments * live tracks) plus a cosine and an IoU for
  /// each pair whose boxes meet.
  TrackedFrame update(const RgbdFrame& frame, const Segmentation& segmentation);

  /// Ends every live track. The tracker can go on with later frames.
  TrackedFrame finish();

  /// Live tracks with kMinDescribed observations or more as they would be if they ended now,
  /// ascending by id: those that have kGrowth times as many as when they were last described, or
  /// all of them. So each is described O(log observations) times. Changes no track.
  static constexpr std::size_t kMinDescribed = 4;
  static constexpr std::size_t kGrowth = 3;
  std::vector<Track> describeLiveTracks(bool all);

  const TrackerCounters& counters() const { return counters_; }
  std::size_t numLiveTracks() const { return live_.size(); }
  std::vector<TrackId> liveIds() const;  ///< ascending

 private:
  struct LiveTrack {
    Track track;
    Eigen::VectorXd feature_sum;  ///< weighted sum of embeddings; empty until there was one
    double feature_weight = 0.0;
    Embedding mean;  ///< feature_sum / feature_weight
    VoxelSet last_voxels;
    ViewRecorder views;
    std::size_t num_described = 0;  ///< observations when it was last described
  };
  /// What a frame shows of its segments, by index.
  struct FrameSegments {
    const Segmentation& segmentation;
    Eigen::Vector3d camera_m;
    std::vector<SegmentPoints> points;
    std::vector<bool> is_selected;
    std::vector<bool> is_cut;
  };

  bool isUsable(const RgbdFrame& frame, const Segmentation& segmentation) const;
  TrackedFrame makeIgnored(Stamp stamp, const Segmentation& segmentation) const;
  std::vector<bool> selectSegments(const std::vector<SegmentPoints>& segments,
                                   std::size_t image_pixels);
  /// A pair of segment and track that overlap by min_iou or more.
  struct Overlap {
    Candidate pair;
    std::optional<double> cosine;  ///< none where one of them has no embedding
  };
  bool adaptsCosine() const;
  std::vector<Overlap> findOverlaps(const FrameSegments& segments) const;
  void addOverlaps(const FrameSegments& segments, std::size_t segment,
                   std::vector<Overlap>& overlaps) const;
  std::vector<Candidate> findCandidates(const std::vector<Overlap>& overlaps) const;
  void countCosines(const std::vector<Overlap>& overlaps);
  void learnCosine(const std::vector<Overlap>& overlaps);
  void associate(const std::vector<Candidate>& matches, FrameSegments& segments,
                 TrackedFrame& result);
  void openTracks(FrameSegments& segments, TrackedFrame& result);
  void observe(LiveTrack& track, std::size_t segment, FrameSegments& segments);
  double computeFeatureWeight(const SegmentView& view, std::size_t pixels) const;
  std::vector<Track> endTracks(Stamp now, double window_s);

  TrackerConfig config_;
  AssociationThresholds thresholds_;
  std::vector<LiveTrack> live_;  ///< ascending by id
  ViewCosine view_cosine_;
  TrackerCounters counters_;
  std::uint64_t next_id_ = 1;
  bool has_stamp_ = false;
  Stamp last_stamp_;
  Eigen::Index embedding_size_ = 0;  ///< 0 until a segmentation with embeddings was seen
};

}  // namespace tsg::tracking
