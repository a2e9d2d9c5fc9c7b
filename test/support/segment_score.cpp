// SPDX-License-Identifier: BSD-3-Clause
#include "segment_score.h"

#include <cstdint>
#include <map>
#include <utility>

namespace tsg::test {
namespace {

struct Counts {
  std::map<int, int> things;
  std::map<int, int> segments;
  std::map<std::pair<int, int>, int> common;
};

Counts countPixels(const cv::Mat& truth, const cv::Mat& labels) {
  Counts counts;
  for (int v = 0; v < truth.rows; ++v) {
    const auto* thing = truth.ptr<std::uint16_t>(v);
    const auto* label = labels.ptr<std::uint16_t>(v);
    for (int u = 0; u < truth.cols; ++u) {
      if (thing[u] != 0) ++counts.things[thing[u]];
      if (label[u] != 0) ++counts.segments[label[u]];
      if (thing[u] != 0 && label[u] != 0) ++counts.common[{thing[u], label[u]}];
    }
  }
  return counts;
}

}  // namespace

std::vector<ThingMatch> matchThings(const cv::Mat& truth, const cv::Mat& labels, int min_area_px,
                                    double min_iou) {
  const Counts counts = countPixels(truth, labels);
  std::vector<ThingMatch> matches;
  for (const auto& [thing, area_px] : counts.things) {
    if (area_px <= min_area_px) continue;
    ThingMatch match{thing, std::nullopt};
    double best = min_iou;
    for (const auto& [label, size_px] : counts.segments) {
      const auto common = counts.common.find({thing, label});
      if (common == counts.common.end()) continue;
      const double iou = static_cast<double>(common->second) / (area_px + size_px - common->second);
      if (iou < best || (match.segment && iou == best)) continue;
      best = iou;
      match.segment = static_cast<std::size_t>(label - 1);
    }
    matches.push_back(match);
  }
  return matches;
}

}  // namespace tsg::test
