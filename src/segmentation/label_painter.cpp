// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/label_painter.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

namespace tsg::segmentation {
namespace {

using Label = std::uint16_t;
using LabelImage = cv::Mat_<Label>;

/// Indices from the largest mask to the smallest; of equal ones the lower score comes first, so
/// that the better one is painted over it.
std::vector<std::size_t> orderForPainting(const std::vector<SegmentMask>& masks) {
  std::vector<std::size_t> order(masks.size());
  std::iota(order.rbegin(), order.rend(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (masks[a].area_px != masks[b].area_px) return masks[a].area_px > masks[b].area_px;
    return masks[a].score < masks[b].score;
  });
  return order;
}

void paint(const SegmentMask& segment, Label label, LabelImage& labels) {
  for (int v = 0; v < segment.mask.rows; ++v) {
    const std::uint8_t* mask = segment.mask.ptr<std::uint8_t>(v);
    Label* row = labels[v + segment.box_px.y] + segment.box_px.x;
    for (int u = 0; u < segment.mask.cols; ++u) row[u] = mask[u] != 0 ? label : row[u];
  }
}

/// Erosion of all segments at once: a pixel stays if its 3x3 neighbours all have its label (outside
/// the image counts as another one).
LabelImage erode(const LabelImage& labels) {
  LabelImage cores(labels.size(), Label{0});
  for (int v = 1; v + 1 < labels.rows; ++v) {
    const Label* above = labels[v - 1];
    const Label* here = labels[v];
    const Label* below = labels[v + 1];
    Label* core = cores[v];
    for (int u = 1; u + 1 < labels.cols; ++u) {
      const Label label = here[u];
      const int others = (above[u - 1] ^ label) | (above[u] ^ label) | (above[u + 1] ^ label) |
                         (here[u - 1] ^ label) | (here[u + 1] ^ label) | (below[u - 1] ^ label) |
                         (below[u] ^ label) | (below[u + 1] ^ label);
      core[u] = others == 0 ? label : Label{0};
    }
  }
  return cores;
}

/// Dilation of the cores. An opening never grows a set, so a pixel can only get its own label back.
void dilateBack(const LabelImage& cores, LabelImage& labels) {
  for (int v = 0; v < labels.rows; ++v) {
    const Label* rows[3] = {cores[std::max(0, v - 1)], cores[v],
                            cores[std::min(labels.rows - 1, v + 1)]};
    Label* here = labels[v];
    for (int u = 0; u < labels.cols; ++u) {
      const int left = std::max(0, u - 1);
      const int right = std::min(labels.cols - 1, u + 1);
      bool found = false;
      for (const Label* row : rows) {
        found |= row[left] == here[u] || row[u] == here[u] || row[right] == here[u];
      }
      if (!found) here[u] = 0;
    }
  }
}

struct Extent {
  int area_px = 0;
  int left = std::numeric_limits<int>::max();
  int right = -1;
  int top = std::numeric_limits<int>::max();
  int bottom = -1;

  cv::Rect box() const { return {left, top, right - left + 1, bottom - top + 1}; }
};

std::vector<Extent> measure(const LabelImage& labels, std::size_t num_labels) {
  std::vector<Extent> extents(num_labels + 1);
  for (int v = 0; v < labels.rows; ++v) {
    const Label* row = labels[v];
    for (int begin = 0, end = 0; begin < labels.cols; begin = end) {
      for (end = begin + 1; end < labels.cols && row[end] == row[begin];) ++end;
      Extent& extent = extents[row[begin]];
      extent.area_px += end - begin;
      extent.left = std::min(extent.left, begin);
      extent.right = std::max(extent.right, end - 1);
      extent.top = std::min(extent.top, v);
      extent.bottom = v;
    }
  }
  return extents;
}

void relabel(const std::vector<Label>& new_labels, LabelImage& labels) {
  for (int v = 0; v < labels.rows; ++v) {
    Label* row = labels[v];
    for (int u = 0; u < labels.cols; ++u) row[u] = new_labels[row[u]];
  }
}

}  // namespace

LabelledSegments paintLabels(const std::vector<SegmentMask>& masks, cv::Size image_size_px,
                             bool refine, int min_area_px) {
  if (masks.size() > std::numeric_limits<Label>::max()) {
    throw std::invalid_argument(std::to_string(masks.size()) +
                                " masks, expected at most 65535 for a 16-bit label image");
  }
  LabelImage labels(image_size_px, Label{0});
  for (const std::size_t i : orderForPainting(masks)) {
    paint(masks[i], static_cast<Label>(i + 1), labels);
  }
  if (refine) dilateBack(erode(labels), labels);

  std::vector<float> scores;
  for (const SegmentMask& mask : masks) scores.push_back(mask.score);
  return collectSegments(labels, scores, min_area_px);
}

LabelledSegments collectSegments(const cv::Mat& labels, const std::vector<float>& scores,
                                 int min_area_px) {
  LabelledSegments segments;
  segments.labels = labels;
  segments.scores = scores;
  const std::vector<Extent> extents = measure(labels, scores.size());
  std::vector<std::size_t> dropped;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const Extent& extent = extents[i + 1];
    segments.boxes_px.push_back(extent.box());
    segments.areas_px.push_back(extent.area_px);
    if (extent.area_px < std::max(1, min_area_px)) dropped.push_back(i);
  }
  dropSegments(dropped, segments);
  return segments;
}

void dropSegments(const std::vector<std::size_t>& dropped, LabelledSegments& segments) {
  if (dropped.empty()) return;
  LabelledSegments kept;
  std::vector<Label> new_labels(segments.scores.size() + 1, 0);
  for (std::size_t i = 0; i < segments.scores.size(); ++i) {
    if (std::binary_search(dropped.begin(), dropped.end(), i)) continue;
    kept.scores.push_back(segments.scores[i]);
    kept.boxes_px.push_back(segments.boxes_px[i]);
    kept.areas_px.push_back(segments.areas_px[i]);
    new_labels[i + 1] = static_cast<Label>(kept.scores.size());
  }
  LabelImage labels = segments.labels;
  relabel(new_labels, labels);
  kept.labels = labels;
  segments = kept;
}

}  // namespace tsg::segmentation
