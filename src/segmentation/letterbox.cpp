// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/letterbox.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

namespace tsg::segmentation {
namespace {

constexpr float kGrey = 114.0F / 255.0F;

std::array<float, 256> makeUnitTable() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = static_cast<float>(i) / 255.0F;
  return table;
}

int scaleSide(int side, double scale, int limit) {
  return std::clamp(static_cast<int>(std::lround(side * scale)), 1, limit);
}

}  // namespace

Letterbox computeLetterbox(cv::Size image_size_px, int input_size_px) {
  if (image_size_px.width <= 0 || image_size_px.height <= 0 || input_size_px <= 0) {
    throw std::invalid_argument("letterbox of a " + std::to_string(image_size_px.width) + "x" +
                                std::to_string(image_size_px.height) + " image in " +
                                std::to_string(input_size_px) + " px, expected positive sizes");
  }
  const double scale =
      static_cast<double>(input_size_px) / std::max(image_size_px.width, image_size_px.height);
  Letterbox letterbox;
  letterbox.input_size_px = input_size_px;
  letterbox.image_size_px = image_size_px;
  cv::Rect& content = letterbox.content_px;
  content.width = scaleSide(image_size_px.width, scale, input_size_px);
  content.height = scaleSide(image_size_px.height, scale, input_size_px);
  content.x = (input_size_px - content.width) / 2;
  content.y = (input_size_px - content.height) / 2;
  letterbox.scale_x = static_cast<double>(content.width) / image_size_px.width;
  letterbox.scale_y = static_cast<double>(content.height) / image_size_px.height;
  return letterbox;
}

void fillLetterboxTensor(const ColorImage& color, const Letterbox& letterbox, float* tensor) {
  static const std::array<float, 256> kUnit = makeUnitTable();
  const cv::Rect& content = letterbox.content_px;
  const int size = letterbox.input_size_px;
  const auto plane = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  cv::Mat resized;
  cv::resize(color.image, resized, content.size(), 0.0, 0.0, cv::INTER_LINEAR);
  if (content.area() < size * size) std::fill(tensor, tensor + 3 * plane, kGrey);
  const int red = color.order == ColorOrder::kRgb ? 0 : 2;
  for (int v = 0; v < content.height; ++v) {
    const std::uint8_t* pixel = resized.ptr<std::uint8_t>(v);
    float* row = tensor + static_cast<std::size_t>(v + content.y) * static_cast<std::size_t>(size) +
                 content.x;
    for (int u = 0; u < content.width; ++u, pixel += 3) {
      row[u] = kUnit[pixel[red]];
      row[plane + static_cast<std::size_t>(u)] = kUnit[pixel[1]];
      row[2 * plane + static_cast<std::size_t>(u)] = kUnit[pixel[2 - red]];
    }
  }
}

}  // namespace tsg::segmentation
