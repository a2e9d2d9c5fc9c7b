// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/embedding_schedule.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace tsg::segmentation {
namespace {

using Memory = EmbeddingSchedule::Memory;

cv::Point2d computeCenter(const cv::Rect& box) {
  return {box.x + box.width / 2.0, box.y + box.height / 2.0};
}

/// How good a view is, in pixels: the square root of the area, less towards the image's corners,
/// half where the border cuts the segment off.
double computeViewQuality(const cv::Rect& box, int area_px, cv::Size image_size) {
  const cv::Point2d center = computeCenter(box);
  const double x = 2.0 * center.x / image_size.width - 1.0;
  const double y = 2.0 * center.y / image_size.height - 1.0;
  const double centrality = 1.0 - 0.5 * std::sqrt((x * x + y * y) / 2.0);
  const bool is_cut = box.x <= 0 || box.y <= 0 || box.x + box.width >= image_size.width ||
                      box.y + box.height >= image_size.height;
  return std::sqrt(static_cast<double>(area_px)) * centrality * (is_cut ? 0.5 : 1.0);
}

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

/// Why a segment needs the encoder, most urgent first.
enum class Need { kNew, kChanged, kBetter, kOld, kNone };

struct Request {
  Need need;
  double quality;
  std::size_t segment;

  bool operator<(const Request& other) const {
    return std::make_tuple(need, -quality, segment) <
           std::make_tuple(other.need, -other.quality, other.segment);
  }
};

Need findNeed(const Memory& memory, Stamp now, const ScheduleConfig& config) {
  if (memory.sum.size() == 0) return Need::kNew;
  const double change = computeMeanColorChange(memory.seen, memory.embedded);
  if (change > config.max_color_change_8bit) return Need::kChanged;
  if (memory.quality_px >= config.min_view_gain * memory.best_quality_px) return Need::kBetter;
  return secondsBetween(memory.embedded_at, now) > config.max_age_s ? Need::kOld : Need::kNone;
}

/// What segments have in common with those of the image before, moved with the image.
struct Overlaps {
  Eigen::MatrixXi common_px;  ///< (label, earlier label); empty: not known
  Eigen::VectorXi areas_px;   ///< by label
  Eigen::RowVectorXi earlier_areas_px;
};

Overlaps computeOverlaps(const EmbeddingSchedule::Plan& plan, const cv::Mat& earlier_labels,
                         std::size_t num_earlier, const ImageMotion& motion) {
  if (motion.isEmpty()) return {};
  Overlaps overlaps;
  overlaps.common_px = countCommonPixels(plan.labels, plan.memories.size(),
                                         moveLabels(earlier_labels, motion), num_earlier);
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

EmbeddingSchedule::EmbeddingSchedule(const ScheduleConfig& config, int crops_per_segment)
    : config_(config), crops_per_segment_(crops_per_segment) {}

bool EmbeddingSchedule::isContinued(const Plan& plan) const {
  const double gap_s = secondsBetween(stamp_, plan.stamp);
  return plan.labels.size() == labels_.size() && gap_s > 0.0 && gap_s <= config_.max_gap_s;
}

std::vector<std::optional<std::size_t>> EmbeddingSchedule::findPredecessors(
    const Plan& plan, const ImageMotion& motion) const {
  const Overlaps overlaps = computeOverlaps(plan, labels_, memories_.size(), motion);
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < plan.memories.size(); ++i) {
    for (std::size_t k = 0; k < memories_.size(); ++k) {
      const auto similarity = computeSimilarity(plan.memories[i], memories_[k],
                                                computeOverlap(overlaps, i, k, config_.min_overlap),
                                                plan.labels.cols, config_);
      if (similarity) pairs.push_back({*similarity, i, k});
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<std::optional<std::size_t>> predecessors(plan.memories.size());
  std::vector<bool> taken(memories_.size(), false);
  for (const Pair& pair : pairs) {
    if (predecessors[pair.segment] || taken[pair.earlier]) continue;
    predecessors[pair.segment] = pair.earlier;
    taken[pair.earlier] = true;
  }
  return predecessors;
}

std::size_t EmbeddingSchedule::computeBudget(std::size_t num_segments) const {
  double crops = std::numeric_limits<double>::infinity();
  if (config_.max_crops_per_frame > 0) crops = config_.max_crops_per_frame;
  if (config_.max_ms_per_frame > 0.0 && ms_per_crop_ > 0.0) {
    crops = std::min(crops, config_.max_ms_per_frame / ms_per_crop_);
  }
  const double segments = std::max(1.0, std::floor(crops / crops_per_segment_));
  return segments < static_cast<double>(num_segments) ? static_cast<std::size_t>(segments)
                                                      : num_segments;
}

EmbeddingSchedule::Plan EmbeddingSchedule::plan(const ColorImage& color,
                                                const LabelledSegments& segments,
                                                const ImageMotion& motion) const {
  Plan plan;
  plan.stamp = color.stamp;
  plan.labels = segments.labels;
  for (std::size_t i = 0; i < segments.boxes_px.size(); ++i) {
    Memory memory;
    memory.box_px = segments.boxes_px[i];
    memory.seen =
        computeAppearance(color, segments.labels, memory.box_px, static_cast<std::uint16_t>(i + 1));
    memory.quality_px = computeViewQuality(memory.box_px, segments.areas_px[i], color.image.size());
    plan.memories.push_back(memory);
  }
  if (isContinued(plan)) inherit(motion, plan);
  choose(plan);
  return plan;
}

void EmbeddingSchedule::inherit(const ImageMotion& motion, Plan& plan) const {
  const auto predecessors = findPredecessors(plan, motion);
  for (std::size_t i = 0; i < plan.memories.size(); ++i) {
    if (!predecessors[i]) continue;
    const Memory& earlier = memories_[*predecessors[i]];
    plan.memories[i].embedded = earlier.embedded;
    plan.memories[i].best_quality_px = earlier.best_quality_px;
    plan.memories[i].embedded_at = earlier.embedded_at;
    plan.memories[i].sum = earlier.sum;
  }
  plan.embed_image = secondsBetween(image_embedded_at_, plan.stamp) >= config_.image_period_s;
}

void EmbeddingSchedule::choose(Plan& plan) const {
  std::vector<Request> requests;
  plan.restart.assign(plan.memories.size(), false);
  for (std::size_t i = 0; i < plan.memories.size(); ++i) {
    const Need need = findNeed(plan.memories[i], plan.stamp, config_);
    plan.restart[i] = need == Need::kNew || need == Need::kChanged;
    requests.push_back({need, plan.memories[i].quality_px, i});
  }
  std::sort(requests.begin(), requests.end());
  const std::size_t limit = computeBudget(requests.size());
  for (const Request& request : requests) {
    if (request.need != Need::kNone && plan.embed.size() < limit) {
      plan.embed.push_back(request.segment);
    } else {
      (request.need == Need::kNew ? plan.dropped : plan.reuse).push_back(request.segment);
    }
  }
  std::sort(plan.reuse.begin(), plan.reuse.end());
  std::sort(plan.dropped.begin(), plan.dropped.end());
}

EmbeddingMatrix EmbeddingSchedule::commit(Plan plan, const EmbeddingMatrix& fresh) {
  for (std::size_t row = 0; row < plan.embed.size(); ++row) {
    const std::size_t i = plan.embed[row];
    Memory& memory = plan.memories[i];
    const Embedding embedding = fresh.row(static_cast<Eigen::Index>(row)).transpose();
    if (plan.restart[i]) {
      memory.sum = Embedding();
      memory.best_quality_px = 0.0;
    }
    if (embedding.isZero(0.0F)) continue;
    const Embedding weighted = static_cast<float>(memory.quality_px) * embedding;
    memory.sum = memory.sum.size() == 0 ? weighted : Embedding(memory.sum + weighted);
    memory.best_quality_px = std::max(memory.best_quality_px, memory.quality_px);
    memory.embedded = memory.seen;
    memory.embedded_at = plan.stamp;
  }
  EmbeddingMatrix rows =
      EmbeddingMatrix::Zero(static_cast<Eigen::Index>(plan.memories.size()), fresh.cols());
  for (std::size_t i = 0; i < plan.memories.size(); ++i) {
    const Embedding& sum = plan.memories[i].sum;
    if (sum.size() > 0) rows.row(static_cast<Eigen::Index>(i)) = sum.normalized().transpose();
  }
  if (plan.embed_image) image_embedded_at_ = plan.stamp;
  memories_ = std::move(plan.memories);
  stamp_ = plan.stamp;
  labels_ = plan.labels.clone();  // the caller's may change when segments are dropped
  return rows;
}

void EmbeddingSchedule::addCost(std::size_t num_crops, double duration_ms) {
  if (num_crops == 0) return;
  const double ms_per_crop = duration_ms / static_cast<double>(num_crops);
  ms_per_crop_ = ms_per_crop_ == 0.0 ? ms_per_crop : 0.9 * ms_per_crop_ + 0.1 * ms_per_crop;
}

}  // namespace tsg::segmentation
