// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/segment_faults.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/simulation/random.h"

namespace tsg::simulation {
namespace {

constexpr int kMinPatch_px = 200;
constexpr std::size_t kFewestToImitate = 3;  // segments of a frame, for its patches

/// Segments in the making: label i + 1 has embeddings[i].
struct Draft {
  cv::Mat labels;
  std::vector<Embedding> embeddings;
  std::vector<float> confidences;

  std::uint16_t add(const Embedding& embedding, float confidence) {
    embeddings.push_back(embedding);
    confidences.push_back(confidence);
    return static_cast<std::uint16_t>(embeddings.size());
  }
};

template <typename Action>
void forEachPixel(const cv::Mat& labels, const Action& action) {
  for (int v = 0; v < labels.rows; ++v) {
    const auto* row = labels.ptr<std::uint16_t>(v);
    for (int u = 0; u < labels.cols; ++u) action(u, v, row[u]);
  }
}

void relabel(cv::Mat& labels, const std::vector<std::uint16_t>& to) {
  for (int v = 0; v < labels.rows; ++v) {
    auto* row = labels.ptr<std::uint16_t>(v);
    for (int u = 0; u < labels.cols; ++u) row[u] = to[row[u]];
  }
}

std::vector<std::uint16_t> makeIdentity(const Draft& draft) {
  std::vector<std::uint16_t> to(draft.embeddings.size() + 1);
  for (std::size_t i = 0; i < to.size(); ++i) to[i] = static_cast<std::uint16_t>(i);
  return to;
}

std::vector<int> countPixels(const Draft& draft) {
  std::vector<int> pixels(draft.embeddings.size() + 1, 0);
  forEachPixel(draft.labels, [&](int, int, std::uint16_t label) { ++pixels[label]; });
  return pixels;
}

Draft makeDraft(const Segmentation& segmentation) {
  Draft draft{segmentation.labels.clone(), {}, {}};
  for (Eigen::Index i = 0; i < segmentation.embeddings.rows(); ++i) {
    draft.add(segmentation.embeddings.row(i).transpose(),
              segmentation.confidences.at(static_cast<std::size_t>(i)));
  }
  return draft;
}

// --- Masks
// ----------------------------------------------------------------------------------------

void drop(double share, Random random, Draft& draft) {
  auto to = makeIdentity(draft);
  for (std::size_t label = 1; label < to.size(); ++label) {
    if (random.chance(share)) to[label] = 0;
  }
  relabel(draft.labels, to);
}

using Borders = std::map<std::pair<std::uint16_t, std::uint16_t>, int>;

/// Pixels at which each two segments meet.
Borders measureBorders(const cv::Mat& labels) {
  Borders borders;
  forEachPixel(labels, [&](int u, int v, std::uint16_t label) {
    const auto meet = [&](int u2, int v2) {
      if (u2 >= labels.cols || v2 >= labels.rows) return;
      const std::uint16_t other = labels.at<std::uint16_t>(v2, u2);
      if (label == 0 || other == 0 || other == label) return;
      ++borders[{label, other}];
      ++borders[{other, label}];
    };
    meet(u + 1, v);
    meet(u, v + 1);
  });
  return borders;
}

std::uint16_t findLongestBorder(const Borders& borders, std::uint16_t label) {
  std::uint16_t best = 0;
  int longest = 0;
  for (auto it = borders.lower_bound({label, 0}); it != borders.end(); ++it) {
    if (it->first.first != label) break;
    if (it->second <= longest) continue;
    longest = it->second;
    best = it->first.second;
  }
  return best;
}

void merge(double share, Random random, Draft& draft) {
  const Borders borders = measureBorders(draft.labels);
  const std::vector<int> pixels = countPixels(draft);
  auto to = makeIdentity(draft);
  for (std::size_t i = 1; i < to.size(); ++i) {
    const auto label = static_cast<std::uint16_t>(i);
    const bool is_merged = random.chance(share);
    const std::uint16_t other = findLongestBorder(borders, label);
    // A segment that has taken part in a union takes part in no other.
    if (!is_merged || other == 0 || to[label] != label || to[other] != other) continue;
    if (std::count(to.begin(), to.end(), label) > 1) continue;
    if (std::count(to.begin(), to.end(), other) > 1) continue;
    to[other] = label;
    Embedding& embedding = draft.embeddings[label - 1U];
    embedding = (static_cast<float>(pixels[label]) * embedding +
                 static_cast<float>(pixels[other]) * draft.embeddings[other - 1U])
                    .normalized();
  }
  relabel(draft.labels, to);
}

struct Line {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();
};

/// Through the centre, across the direction in which the segment is longest.
Line findCut(const cv::Mat& mask) {
  const cv::Moments m = cv::moments(mask, true);
  const double angle_rad = 0.5 * std::atan2(2.0 * m.mu11, m.mu20 - m.mu02);
  return {{m.m10 / m.m00, m.m01 / m.m00}, {std::cos(angle_rad), std::sin(angle_rad)}};
}

void split(double share, Random random, Draft& draft) {
  const std::vector<int> pixels = countPixels(draft);
  for (std::size_t i = 1; i < pixels.size(); ++i) {
    const auto label = static_cast<std::uint16_t>(i);
    if (!random.chance(share) || pixels[i] == 0) continue;
    const Line cut = findCut(draft.labels == label);
    const Embedding embedding = draft.embeddings[i - 1];
    const std::uint16_t half = draft.add(embedding, draft.confidences[i - 1]);
    for (int v = 0; v < draft.labels.rows; ++v) {
      auto* row = draft.labels.ptr<std::uint16_t>(v);
      for (int u = 0; u < draft.labels.cols; ++u) {
        const bool is_behind = cut.normal.dot(Eigen::Vector2d(u, v) - cut.point) > 0.0;
        if (row[u] == label && is_behind) row[u] = half;
      }
    }
  }
}

void erode(int distance_px, Draft& draft) {
  const cv::Mat disk = cv::getStructuringElement(
      cv::MORPH_ELLIPSE, cv::Size(2 * distance_px + 1, 2 * distance_px + 1));
  cv::Mat least, largest;
  cv::erode(draft.labels, least, disk);
  cv::dilate(draft.labels, largest, disk);
  draft.labels.setTo(0, least != largest);
}

Embedding addNoise(const Embedding& embedding, double length, Random& random) {
  const double step = length / std::sqrt(static_cast<double>(embedding.size()));
  Embedding noisy = embedding;
  for (Eigen::Index i = 0; i < noisy.size(); ++i) {
    noisy[i] += static_cast<float>(step * random.normal());
  }
  return noisy.normalized();
}

/// Of walls and floors: what all segments of the frame have in common, and for the rest a direction
/// of its own, the same in all frames. So a patch is as far from each task as things usually are,
/// however many views are averaged; the common part alone would be near to every task.
Embedding makePatchEmbedding(const std::vector<Embedding>& embeddings, int seed) {
  Embedding common = Embedding::Zero(embeddings.front().size());
  for (const Embedding& embedding : embeddings) common += embedding;
  common /= static_cast<float>(embeddings.size());
  Random random(combineSeeds(static_cast<std::uint64_t>(seed), hashText("background")));
  Embedding own(common.size());
  for (Eigen::Index i = 0; i < own.size(); ++i) own[i] = static_cast<float>(random.normal());
  const float left = std::max(0.0F, 1.0F - common.squaredNorm());
  return (common + std::sqrt(left) * own.normalized()).normalized();
}

void addPatches(const SegmentFaultsConfig& config, Random random, Draft& draft) {
  if (draft.embeddings.size() < kFewestToImitate) return;
  const Embedding embedding = makePatchEmbedding(draft.embeddings, config.seed);
  const cv::Mat& labels = draft.labels;
  for (int i = 0; i < config.patches; ++i) {
    const int width = std::max(1, labels.cols / (4 + random.integer(8)));
    const int height = std::max(1, labels.rows / (4 + random.integer(8)));
    const cv::Rect where(random.integer(labels.cols - width + 1),
                         random.integer(labels.rows - height + 1), width, height);
    const cv::Mat mask = draft.labels(where) == 0;
    if (cv::countNonZero(mask) < kMinPatch_px) continue;
    draft.labels(where).setTo(draft.add(embedding, 0.5F), mask);
  }
}

// --- Result
// ---------------------------------------------------------------------------------------

void spoilEmbeddings(const SegmentFaultsConfig& config, Random random, Draft& draft) {
  const std::vector<int> pixels = countPixels(draft);
  const double variance = 1.0 / config.view_cosine - 1.0;
  for (std::size_t i = 0; i < draft.embeddings.size(); ++i) {
    Embedding& embedding = draft.embeddings[i];
    if (pixels[i + 1] == 0 || embedding.isZero(0.0F)) continue;
    const double growth = 1.0 + config.small_crop_px / pixels[i + 1];
    embedding = addNoise(embedding, std::sqrt(variance * growth), random);
  }
}

/// Leaves out segments without a pixel.
Segmentation finish(Draft draft, const Segmentation& original) {
  const std::vector<int> pixels = countPixels(draft);
  std::vector<std::uint16_t> to(pixels.size(), 0);
  std::vector<std::size_t> kept;
  for (std::size_t label = 1; label < pixels.size(); ++label) {
    if (pixels[label] == 0) continue;
    kept.push_back(label - 1);
    to[label] = static_cast<std::uint16_t>(kept.size());
  }
  relabel(draft.labels, to);
  Segmentation result;
  result.stamp = original.stamp;
  result.labels = draft.labels;
  result.image_embedding = original.image_embedding;
  result.embeddings.resize(static_cast<Eigen::Index>(kept.size()), original.embeddings.cols());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    result.embeddings.row(static_cast<Eigen::Index>(i)) = draft.embeddings[kept[i]].transpose();
    result.confidences.push_back(draft.confidences[kept[i]]);
  }
  return result;
}

}  // namespace

SegmentFaultsConfig SegmentFaultsConfig::makeClipLike() {
  SegmentFaultsConfig config;
  config.view_cosine = 0.9;
  config.small_crop_px = 500.0;
  config.dropped = 0.1;
  config.merged = 0.05;
  config.split = 0.05;
  config.eroded_px = 1;
  config.patches = 2;
  return config;
}

SegmentFaultsConfig SegmentFaultsConfig::makeHard() {
  SegmentFaultsConfig config;
  config.view_cosine = 0.85;
  config.small_crop_px = 1000.0;
  config.dropped = 0.25;
  config.merged = 0.1;
  config.split = 0.15;
  config.eroded_px = 2;
  config.patches = 4;
  return config;
}

SegmentFaults::SegmentFaults(const SegmentFaultsConfig& config) : config_(config) {
  config::validate(config, "segment faults");
}

Segmentation SegmentFaults::apply(const Segmentation& segmentation) const {
  segmentation.validate();
  Random random(combineSeeds(static_cast<std::uint64_t>(config_.seed),
                             static_cast<std::uint64_t>(segmentation.stamp.ns)));
  Draft draft = makeDraft(segmentation);
  if (config_.dropped > 0.0) drop(config_.dropped, random.fork("dropped"), draft);
  if (config_.merged > 0.0) merge(config_.merged, random.fork("merged"), draft);
  if (config_.split > 0.0) split(config_.split, random.fork("split"), draft);
  if (config_.eroded_px > 0) erode(config_.eroded_px, draft);
  if (config_.patches > 0) addPatches(config_, random.fork("patches"), draft);
  if (config_.view_cosine < 1.0) spoilEmbeddings(config_, random.fork("embeddings"), draft);
  return finish(std::move(draft), segmentation);
}

}  // namespace tsg::simulation
