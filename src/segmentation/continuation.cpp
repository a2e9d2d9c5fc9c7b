// SPDX-License-Identifier: BSD-3-Clause
#include "continuation.h"

#include <algorithm>
#include <tuple>

namespace tsg::segmentation {
namespace {

using Memory = EmbeddingSchedule::Memory;

/// A segment may continue an earlier one.
struct Pair {
  double similarity;
  std::size_t segment;
  std::size_t earlier;

  /// Most similar first; ties by index, so that the order is a total one.
  bool operator<(const Pair& other) const {
    return std::make_tuple(-similarity, segment, earlier) <
           std::make_tuple(-other.similarity, other.segment, other.earlier);
  }
};

/// What segments have in common with those of the image before, moved with the image.
struct Overlaps {
  Eigen::MatrixXi common_px;  ///< (label, earlier label); empty: not known
  Eigen::VectorXi areas_px;   ///< by label
  Eigen::RowVectorXi earlier_areas_px;
};

Overlaps computeOverlaps(const SegmentsSeen& now, const SegmentsSeen& earlier,
                         const ImageMotion& motion) {
  if (motion.isEmpty()) return {};
  Overlaps overlaps;
  overlaps.common_px = countCommonPixels(
      now.labels, now.memories.size(), moveLabels(earlier.labels, motion), earlier.memories.size());
  overlaps.areas_px = overlaps.common_px.rowwise().sum();
  overlaps.earlier_areas_px = overlaps.common_px.colwise().sum();
  return overlaps;
}

/// Mean of the IoU and of the common share of the smaller one; 0 if that share is too small.
double computeOverlap(const Overlaps& overlaps, std::size_t segment, std::size_t earlier,
                      double min_share) {
  if (overlaps.common_px.size() == 0) return 0.0;
  const auto row = static_cast<Eigen::Index>(segment) + 1;
  const auto column = static_cast<Eigen::Index>(earlier) + 1;
  const double common = overlaps.common_px(row, column);
  const double area = overlaps.areas_px[row];
  const double earlier_area = overlaps.earlier_areas_px[column];
  const double smaller = std::min(area, earlier_area);
  if (common == 0.0 || common < min_share * smaller) return 0.0;
  return 0.5 * common / smaller + 0.5 * common / (area + earlier_area - common);
}

/// How alike two segments are that may be one, greater is better; nothing if they cannot be.
std::optional<double> computeSimilarity(const Memory& now, const Memory& earlier, double overlap,
                                        double image_width_px, const ScheduleConfig& config) {
  std::optional<double> similarity;
  if (overlap > 0.0) {
    const double change = computeMeanColorChange(now.seen, earlier.seen);
    if (change <= config.max_color_change_8bit) similarity = overlap * (1.0 - change / 255.0);
  }
  const double shift =
      cv::norm(computeCenter(now.box_px) - computeCenter(earlier.box_px)) / image_width_px;
  if (shift > config.max_shift) return similarity;
  const double iou = computeMaskIou(now.seen, earlier.seen);
  if (iou < config.min_mask_iou) return similarity;
  const double change = computeColorChange(now.seen, earlier.seen);
  return std::max(similarity.value_or(-1.0), iou * (1.0 - change / 255.0) - shift);
}

}  // namespace

std::vector<std::optional<std::size_t>> findPredecessors(const SegmentsSeen& now,
                                                         const SegmentsSeen& earlier,
                                                         const ImageMotion& motion,
                                                         const ScheduleConfig& config) {
  const Overlaps overlaps = computeOverlaps(now, earlier, motion);
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < now.memories.size(); ++i) {
    for (std::size_t k = 0; k < earlier.memories.size(); ++k) {
      const auto similarity = computeSimilarity(now.memories[i], earlier.memories[k],
                                                computeOverlap(overlaps, i, k, config.min_overlap),
                                                now.labels.cols, config);
      if (similarity) pairs.push_back({*similarity, i, k});
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<std::optional<std::size_t>> predecessors(now.memories.size());
  std::vector<bool> taken(earlier.memories.size(), false);
  for (const Pair& pair : pairs) {
    if (predecessors[pair.segment] || taken[pair.earlier]) continue;
    predecessors[pair.segment] = pair.earlier;
    taken[pair.earlier] = true;
  }
  return predecessors;
}

}  // namespace tsg::segmentation
