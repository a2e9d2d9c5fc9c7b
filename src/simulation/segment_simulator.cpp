// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/segment_simulator.h"

#include <algorithm>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/simulation/random.h"

namespace tsg::simulation {
namespace {

std::uint64_t seedOf(const Apartment& apartment, std::int64_t frame, std::uint64_t what) {
  const std::uint64_t own = combineSeeds(static_cast<std::uint64_t>(apartment.config.seed), what);
  return combineSeeds(own, static_cast<std::uint64_t>(frame));
}

std::vector<int> countPixels(const cv::Mat& parts, std::size_t num_parts) {
  std::vector<int> pixels(num_parts + 1, 0);
  for (int v = 0; v < parts.rows; ++v) {
    const auto* row = parts.ptr<std::uint16_t>(v);
    for (int u = 0; u < parts.cols; ++u) ++pixels[row[u]];
  }
  return pixels;
}

cv::Mat renumber(const cv::Mat& parts, const std::vector<std::uint16_t>& segment_of_part) {
  cv::Mat labels(parts.size(), CV_16UC1);
  for (int v = 0; v < parts.rows; ++v) {
    const auto* from = parts.ptr<std::uint16_t>(v);
    auto* to = labels.ptr<std::uint16_t>(v);
    for (int u = 0; u < parts.cols; ++u) to[u] = segment_of_part[from[u]];
  }
  return labels;
}

}  // namespace

SegmentSimulator::SegmentSimulator(const Apartment& apartment, const SegmentConfig& config)
    : apartment_(apartment), config_(config) {
  config::validate(config, "segments");
}

Embedding SegmentSimulator::embedPart(std::uint16_t part, std::int64_t frame) const {
  const Part& info = apartment_.parts.at(part - 1U);
  const std::string& phrase = apartment_.instances[info.instance - 1U].phrase;
  return space_.encodeImage(EmbeddingSpace::makePart(phrase, info.name), phrase,
                            seedOf(apartment_, 0, part), seedOf(apartment_, frame + 1, part));
}

Embedding SegmentSimulator::embedImage(const RenderedView& view, std::int64_t frame) const {
  EmbeddingSpace::Mixture rooms;
  for (std::size_t i = 1; i < view.room_pixels.size(); ++i) {
    if (view.room_pixels[i] > 0) {
      rooms.emplace_back(apartment_.rooms[i - 1].phrase, static_cast<double>(view.room_pixels[i]));
    }
  }
  const std::uint64_t seed = seedOf(apartment_, frame, hashText("image"));
  // Successive views look alike: their appearance changes once in a second or so.
  const std::uint64_t slow = seedOf(apartment_, frame / 10, hashText("scenery"));
  return space_.encodeImage(rooms, "indoor scene", slow, seed);
}

Segmentation SegmentSimulator::segment(const RenderedView& view, Stamp stamp,
                                       std::int64_t frame) const {
  const std::vector<int> pixels = countPixels(view.parts, apartment_.parts.size());
  std::vector<std::uint16_t> segment_of_part(pixels.size(), 0);
  std::vector<std::uint16_t> found;
  for (std::size_t part = 1; part < pixels.size(); ++part) {
    const std::uint64_t chance = seedOf(apartment_, frame, part + hashText("dropout"));
    if (pixels[part] < config_.min_pixels || toUnitInterval(chance) < config_.dropout) continue;
    found.push_back(static_cast<std::uint16_t>(part));
    segment_of_part[part] = static_cast<std::uint16_t>(found.size());
  }
  Segmentation result;
  result.stamp = stamp;
  result.labels = renumber(view.parts, segment_of_part);
  result.embeddings.resize(static_cast<Eigen::Index>(found.size()), EmbeddingSpace::kSize);
  for (std::size_t i = 0; i < found.size(); ++i) {
    result.embeddings.row(static_cast<Eigen::Index>(i)) = embedPart(found[i], frame).transpose();
    const auto size = static_cast<float>(pixels[found[i]]);
    result.confidences.push_back(size / (size + static_cast<float>(config_.min_pixels)));
  }
  result.image_embedding = embedImage(view, frame);
  return result;
}

}  // namespace tsg::simulation
