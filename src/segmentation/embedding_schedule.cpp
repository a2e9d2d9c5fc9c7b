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
enum class Need { kNew, kChanged, kOld, kNone };

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
  const bool is_unchanged =
      computeMaskIou(memory.seen, memory.embedded) >= config.min_mask_iou &&
      computeColorChange(memory.seen, memory.embedded) <= config.max_color_change_8bit;
  if (!is_unchanged) return Need::kChanged;
  return secondsBetween(memory.embedded_at, now) > config.max_age_s ? Need::kOld : Need::kNone;
}

}  // namespace

EmbeddingSchedule::EmbeddingSchedule(const ScheduleConfig& config, int crops_per_segment)
    : config_(config), crops_per_segment_(crops_per_segment) {}

bool EmbeddingSchedule::isContinued(const Plan& plan) const {
  const double gap_s = secondsBetween(stamp_, plan.stamp);
  return plan.image_size_px == image_size_px_ && gap_s > 0.0 && gap_s <= config_.max_gap_s;
}

std::vector<std::optional<std::size_t>> EmbeddingSchedule::findPredecessors(
    const Plan& plan) const {
  const double max_shift_px = config_.max_shift * plan.image_size_px.width;
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < plan.memories.size(); ++i) {
    const cv::Point2d center = computeCenter(plan.memories[i].box_px);
    for (std::size_t k = 0; k < memories_.size(); ++k) {
      const double shift_px = cv::norm(center - computeCenter(memories_[k].box_px));
      if (shift_px > max_shift_px) continue;
      const double iou = computeMaskIou(plan.memories[i].seen, memories_[k].seen);
      if (iou < config_.min_mask_iou) continue;
      const double change = computeColorChange(plan.memories[i].seen, memories_[k].seen) / 255.0;
      const double shift = shift_px / plan.image_size_px.width;
      pairs.push_back({iou * (1.0 - change) - shift, i, k});
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

std::size_t EmbeddingSchedule::budget(std::size_t num_segments) const {
  if (config_.max_crops_per_frame == 0) return num_segments;
  return static_cast<std::size_t>(std::max(1, config_.max_crops_per_frame / crops_per_segment_));
}

EmbeddingSchedule::Plan EmbeddingSchedule::plan(const ColorImage& color,
                                                const LabelledSegments& segments) const {
  Plan plan;
  plan.stamp = color.stamp;
  plan.image_size_px = color.image.size();
  for (std::size_t i = 0; i < segments.boxes_px.size(); ++i) {
    const cv::Rect& box = segments.boxes_px[i];
    const auto label = static_cast<std::uint16_t>(i + 1);
    plan.memories.push_back(
        {box, computeAppearance(color, segments.labels, box, label), {}, {}, {}});
  }
  if (isContinued(plan)) inherit(plan);
  choose(segments.areas_px, plan);
  return plan;
}

void EmbeddingSchedule::inherit(Plan& plan) const {
  const auto predecessors = findPredecessors(plan);
  for (std::size_t i = 0; i < plan.memories.size(); ++i) {
    if (!predecessors[i]) continue;
    const Memory& earlier = memories_[*predecessors[i]];
    plan.memories[i].embedded = earlier.embedded;
    plan.memories[i].embedded_at = earlier.embedded_at;
    plan.memories[i].sum = earlier.sum;
  }
  plan.embed_image = secondsBetween(image_embedded_at_, plan.stamp) >= config_.image_period_s;
}

void EmbeddingSchedule::choose(const std::vector<int>& areas_px, Plan& plan) const {
  std::vector<Request> requests;
  plan.restart.assign(plan.memories.size(), false);
  for (std::size_t i = 0; i < plan.memories.size(); ++i) {
    const Memory& memory = plan.memories[i];
    const Need need = findNeed(memory, plan.stamp, config_);
    plan.restart[i] = need != Need::kOld;
    requests.push_back(
        {need, computeViewQuality(memory.box_px, areas_px[i], plan.image_size_px), i});
  }
  std::sort(requests.begin(), requests.end());
  const std::size_t limit = budget(requests.size());
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
    if (plan.restart[i]) memory.sum = Embedding();
    if (embedding.isZero(0.0F)) continue;
    memory.sum = memory.sum.size() == 0 ? embedding : Embedding(memory.sum + embedding);
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
  image_size_px_ = plan.image_size_px;
  return rows;
}

}  // namespace tsg::segmentation
