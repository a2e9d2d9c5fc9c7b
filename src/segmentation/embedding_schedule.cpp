// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/embedding_schedule.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "continuation.h"

namespace tsg::segmentation {
namespace {

using Memory = EmbeddingSchedule::Memory;

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

}  // namespace

EmbeddingSchedule::EmbeddingSchedule(const ScheduleConfig& config, int crops_per_segment)
    : config_(config), crops_per_segment_(crops_per_segment) {}

bool EmbeddingSchedule::isContinued(const Plan& plan) const {
  const double gap_s = secondsBetween(stamp_, plan.stamp);
  return plan.labels.size() == labels_.size() && gap_s > 0.0 && gap_s <= config_.max_gap_s;
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
  const auto predecessors =
      findPredecessors({plan.memories, plan.labels}, {memories_, labels_}, motion, config_);
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
