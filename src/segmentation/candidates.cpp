// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "task_scene_graph/segmentation/mask_decoder.h"

namespace tsg::segmentation {
namespace {

cv::Rect2f readBox(const RawDetections& raw, std::size_t anchor) {
  const auto value = [&](std::size_t row) {
    return raw.predictions[row * raw.num_anchors + anchor];
  };
  const float width = value(2);
  const float height = value(3);
  return {value(0) - 0.5F * width, value(1) - 0.5F * height, width, height};
}

bool isUsable(const cv::Rect2f& box) {
  return std::isfinite(box.x) && std::isfinite(box.y) && std::isfinite(box.width) &&
         std::isfinite(box.height) && box.width > 0.0F && box.height > 0.0F;
}

std::vector<float> computeBestScores(const RawDetections& raw) {
  const float* first = raw.predictions + 4 * raw.num_anchors;
  std::vector<float> best(first, first + raw.num_anchors);
  for (std::size_t c = 1; c < static_cast<std::size_t>(raw.num_classes); ++c) {
    const float* scores = first + c * raw.num_anchors;
    for (std::size_t a = 0; a < raw.num_anchors; ++a) best[a] = std::max(best[a], scores[a]);
  }
  return best;
}

float computeIou(const cv::Rect2f& a, const cv::Rect2f& b) {
  const float width = std::min(a.x + a.width, b.x + b.width) - std::max(a.x, b.x);
  const float height = std::min(a.y + a.height, b.y + b.height) - std::max(a.y, b.y);
  if (width <= 0.0F || height <= 0.0F) return 0.0F;
  const float common = width * height;
  return common / (a.area() + b.area() - common);
}

}  // namespace

std::vector<Detection> findCandidates(const RawDetections& raw, double score_threshold) {
  const std::vector<float> scores = computeBestScores(raw);
  const auto threshold = static_cast<float>(score_threshold);
  std::vector<Detection> candidates;
  for (std::size_t a = 0; a < raw.num_anchors; ++a) {
    if (!(scores[a] > threshold)) continue;  // also drops NaN
    const cv::Rect2f box = readBox(raw, a);
    if (isUsable(box)) candidates.push_back({box, std::min(scores[a], 1.0F), a});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  return candidates;
}

std::vector<Detection> suppressOverlaps(const std::vector<Detection>& best_first,
                                        double iou_threshold, std::size_t max_kept) {
  const auto threshold = static_cast<float>(iou_threshold);
  std::vector<Detection> kept;
  for (const Detection& candidate : best_first) {
    if (kept.size() >= max_kept) break;
    const bool repeated = std::any_of(kept.begin(), kept.end(), [&](const Detection& better) {
      return computeIou(better.box_px, candidate.box_px) > threshold;
    });
    if (!repeated) kept.push_back(candidate);
  }
  return kept;
}

}  // namespace tsg::segmentation
