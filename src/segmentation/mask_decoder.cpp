// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/mask_decoder.h"

#include <algorithm>
#include <cmath>

namespace tsg::segmentation {
namespace {

/// One axis of the bilinear interpolation: where each image pixel of a box lies on the prototypes'
/// grid.
struct Axis {
  int first_cell = 0;
  int num_cells = 0;
  std::vector<int> cell;        ///< per pixel: lower neighbour, counted from first_cell
  std::vector<float> fraction;  ///< per pixel: weight of the upper neighbour
};

/// Geometry of one image axis against the grid of `grid_size` cells over the network's input.
struct AxisMap {
  double scale;  ///< input pixels per image pixel
  double offset_px;
  double cells_per_px;
  double first_cell;  ///< cells wholly inside the image's content
  double last_cell;
};

AxisMap makeAxisMap(double scale, int offset_px, int content_px, int input_px, int grid_size) {
  AxisMap map{scale, static_cast<double>(offset_px), static_cast<double>(grid_size) / input_px, 0.0,
              grid_size - 1.0};
  const double first = std::ceil(offset_px * map.cells_per_px);
  const double last = std::floor((offset_px + content_px) * map.cells_per_px) - 1.0;
  if (first <= last) {
    map.first_cell = first;
    map.last_cell = last;
  }
  return map;
}

Axis makeAxis(const AxisMap& map, int first_pixel, int num_pixels) {
  const auto position = [&](int pixel) {
    const double input = (pixel + 0.5) * map.scale + map.offset_px;
    return std::clamp(input * map.cells_per_px - 0.5, map.first_cell, map.last_cell);
  };
  Axis axis;
  axis.first_cell = static_cast<int>(position(first_pixel));
  // One cell more than the last lower neighbour; the clamped end needs none.
  const int last = std::min(static_cast<int>(position(first_pixel + num_pixels - 1)) + 1,
                            static_cast<int>(map.last_cell));
  axis.num_cells = last - axis.first_cell + 1;
  axis.cell.resize(static_cast<std::size_t>(num_pixels));
  axis.fraction.resize(static_cast<std::size_t>(num_pixels));
  for (int i = 0; i < num_pixels; ++i) {
    const double at = position(first_pixel + i);
    const int lower =
        std::max(0, std::min(static_cast<int>(at) - axis.first_cell, axis.num_cells - 2));
    axis.cell[static_cast<std::size_t>(i)] = lower;
    axis.fraction[static_cast<std::size_t>(i)] = static_cast<float>(at - axis.first_cell - lower);
  }
  return axis;
}

/// First image pixel inside [begin, begin + length), given in input pixels, and their number.
std::pair<int, int> pixelsInside(double begin, double length, double offset, double scale,
                                 int size) {
  const auto toImage = [&](double input) {
    return std::clamp((input - offset) / scale, 0.0, static_cast<double>(size));
  };
  const int first = static_cast<int>(std::ceil(toImage(begin)));
  const int end = static_cast<int>(std::ceil(toImage(begin + length)));
  return {first, end - first};
}

cv::Rect toImageBox(const cv::Rect2f& box, const Letterbox& letterbox) {
  const cv::Rect& content = letterbox.content_px;
  const cv::Size& size = letterbox.image_size_px;
  const auto [x, width] = pixelsInside(box.x, box.width, content.x, letterbox.scale_x, size.width);
  const auto [y, height] =
      pixelsInside(box.y, box.height, content.y, letterbox.scale_y, size.height);
  return {x, y, width, height};
}

/// Mask logits on the cells that the box needs.
cv::Mat1f computeLogits(const RawDetections& raw, std::size_t anchor, const Axis& x,
                        const Axis& y) {
  cv::Mat1f logits(y.num_cells, x.num_cells, 0.0F);
  const auto side = static_cast<std::size_t>(raw.prototype_size_px);
  const auto first_weight = static_cast<std::size_t>(4 + raw.num_classes);
  for (std::size_t k = 0; k < static_cast<std::size_t>(raw.num_prototypes); ++k) {
    const float weight = raw.predictions[(first_weight + k) * raw.num_anchors + anchor];
    const float* prototype =
        raw.prototypes + k * side * side + static_cast<std::size_t>(x.first_cell);
    for (int r = 0; r < y.num_cells; ++r) {
      const float* from = prototype + static_cast<std::size_t>(y.first_cell + r) * side;
      float* to = logits[r];
      for (int c = 0; c < x.num_cells; ++c) to[c] += weight * from[c];
    }
  }
  return logits;
}

/// Every row of cells, interpolated along x to the box's columns.
cv::Mat1f widenRows(const cv::Mat1f& logits, const Axis& x) {
  cv::Mat1f wide(logits.rows, static_cast<int>(x.cell.size()));
  const int step = logits.cols > 1 ? 1 : 0;
  for (int r = 0; r < logits.rows; ++r) {
    const float* from = logits[r];
    float* to = wide[r];
    for (std::size_t i = 0; i < x.cell.size(); ++i) {
      const float* cell = from + x.cell[i];
      to[i] = cell[0] + x.fraction[i] * (cell[step] - cell[0]);
    }
  }
  return wide;
}

/// Interpolates along y and keeps the sign; returns the number of ones.
int thresholdRows(const cv::Mat1f& wide, const Axis& y, cv::Mat& mask) {
  int area = 0;
  const int step = wide.rows > 1 ? 1 : 0;
  for (int v = 0; v < mask.rows; ++v) {
    const float* lower = wide[y.cell[static_cast<std::size_t>(v)]];
    const float* upper = wide[y.cell[static_cast<std::size_t>(v)] + step];
    const float fraction = y.fraction[static_cast<std::size_t>(v)];
    std::uint8_t* to = mask.ptr<std::uint8_t>(v);
    for (int u = 0; u < mask.cols; ++u) {
      to[u] = lower[u] + fraction * (upper[u] - lower[u]) > 0.0F ? 1 : 0;
      area += to[u];
    }
  }
  return area;
}

}  // namespace

SegmentMask decodeMask(const RawDetections& raw, const Detection& detection,
                       const Letterbox& letterbox) {
  SegmentMask segment;
  segment.score = detection.score;
  segment.box_px = toImageBox(detection.box_px, letterbox);
  if (segment.box_px.empty()) return segment;
  const cv::Rect& content = letterbox.content_px;
  const AxisMap x_map = makeAxisMap(letterbox.scale_x, content.x, content.width,
                                    letterbox.input_size_px, raw.prototype_size_px);
  const AxisMap y_map = makeAxisMap(letterbox.scale_y, content.y, content.height,
                                    letterbox.input_size_px, raw.prototype_size_px);
  const Axis x = makeAxis(x_map, segment.box_px.x, segment.box_px.width);
  const Axis y = makeAxis(y_map, segment.box_px.y, segment.box_px.height);
  const cv::Mat1f logits = computeLogits(raw, detection.anchor, x, y);
  segment.mask.create(segment.box_px.size(), CV_8UC1);
  segment.area_px = thresholdRows(widenRows(logits, x), y, segment.mask);
  return segment;
}

}  // namespace tsg::segmentation
