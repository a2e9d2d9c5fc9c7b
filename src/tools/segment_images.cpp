// SPDX-License-Identifier: BSD-3-Clause
// Draws the segments that a model set finds over images, to see what its thresholds do.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/segmentation/model_set.h"
#include "task_scene_graph/segmentation/segmenter.h"

namespace fs = std::filesystem;
using namespace task_scene_graph;

namespace {

constexpr const char* kUsage =
    "usage: segment_images --models M.yaml --output DIR [options] IMAGE...\n"
    "Draws the segments found in each image over it and writes DIR/<image name>.png.\n"
    "  --config C.yaml         parameters of the segmenter (below)\n"
    "  --score-threshold X     in place of the model set's\n"
    "  --iou-threshold X       in place of the model set's\n"
    "  --embed                 also embed the segments, to see how long that takes\n"
    "  --help                  this text and the parameters\n";

struct Arguments {
  std::string models;
  std::string output;
  std::vector<std::string> images;
  segmentation::SegmenterConfig config;
};

void printHelp() {
  std::cout << kUsage << "parameters:\n";
  for (const auto& row : config::describe<segmentation::SegmenterConfig>()) {
    std::cout << "  " << row.name << " (" << row.default_value << "): " << row.doc << '\n';
  }
}

double toNumber(const std::string& option, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (!text.empty() && *end == '\0') return value;
  throw std::invalid_argument(option + " is '" + text + "', expected a number");
}

void disableEmbedding(segmentation::SegmenterConfig& config) {
  config.embed_crop = config.embed_masked_crop = config.embed_image = false;
}

Arguments parse(const std::vector<std::string>& words) {
  Arguments arguments;
  bool embed = false;
  std::vector<std::pair<std::string, double>> thresholds;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const auto next = [&] {
      if (i + 1 == words.size()) throw std::invalid_argument(word + " needs a value");
      return words[++i];
    };
    if (word == "--models") {
      arguments.models = next();
    } else if (word == "--output") {
      arguments.output = next();
    } else if (word == "--config") {
      const std::string path = next();
      arguments.config = config::load<segmentation::SegmenterConfig>(config::loadYamlFile(path),
                                                                     "parameters '" + path + "'");
    } else if (word == "--score-threshold" || word == "--iou-threshold") {
      thresholds.emplace_back(word, toNumber(word, next()));
    } else if (word == "--embed") {
      embed = true;
    } else if (word.rfind("--", 0) == 0) {
      throw std::invalid_argument("unknown option " + word);
    } else {
      arguments.images.push_back(word);
    }
  }
  for (const auto& [option, value] : thresholds) {
    (option == "--score-threshold" ? arguments.config.score_threshold
                                   : arguments.config.iou_threshold) = value;
  }
  if (!embed) disableEmbedding(arguments.config);
  if (arguments.models.empty()) throw std::invalid_argument("--models is missing");
  if (arguments.output.empty()) throw std::invalid_argument("--output is missing");
  if (arguments.images.empty()) throw std::invalid_argument("no image given");
  return arguments;
}

/// Neighbouring labels get colours far apart: hues a golden angle from each other.
cv::Vec3b colorOf(int label) {
  const cv::Mat3b hsv(1, 1, cv::Vec3b(static_cast<std::uint8_t>(label * 111 % 180), 200, 255));
  cv::Mat3b bgr;
  cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
  return bgr(0, 0);
}

bool isEdge(const cv::Mat1w& labels, int u, int v) {
  const auto label = labels(v, u);
  return (u + 1 < labels.cols && labels(v, u + 1) != label) ||
         (v + 1 < labels.rows && labels(v + 1, u) != label);
}

cv::Mat3b drawSegments(const cv::Mat3b& image, const Segmentation& segmentation) {
  const cv::Mat1w labels = segmentation.labels;
  std::vector<cv::Vec3b> colors;
  for (std::size_t i = 0; i <= segmentation.numSegments(); ++i) {
    colors.push_back(colorOf(static_cast<int>(i)));
  }
  cv::Mat3b drawn = image.clone();
  for (int v = 0; v < labels.rows; ++v) {
    for (int u = 0; u < labels.cols; ++u) {
      if (isEdge(labels, u, v)) {
        drawn(v, u) = cv::Vec3b(255, 255, 255);
      } else if (labels(v, u) != 0) {
        drawn(v, u) = 0.5 * image(v, u) + 0.5 * colors[labels(v, u)];
      }
    }
  }
  return drawn;
}

void writeScores(const Segmentation& segmentation, cv::Mat3b& drawn) {
  for (std::size_t i = 0; i < segmentation.confidences.size(); ++i) {
    const cv::Moments moments =
        cv::moments(segmentation.labels == static_cast<double>(i + 1), /*binaryImage=*/true);
    const cv::Point center(static_cast<int>(moments.m10 / moments.m00) - 12,
                           static_cast<int>(moments.m01 / moments.m00) + 4);
    char text[16];
    std::snprintf(text, sizeof text, "%.2f", static_cast<double>(segmentation.confidences[i]));
    cv::putText(drawn, text, center, cv::FONT_HERSHEY_SIMPLEX, 0.35, {0, 0, 0}, 2, cv::LINE_AA);
    cv::putText(drawn, text, center, cv::FONT_HERSHEY_SIMPLEX, 0.35, {255, 255, 255}, 1,
                cv::LINE_AA);
  }
}

void segmentFile(const std::string& path, const fs::path& output,
                 segmentation::Segmenter& segmenter) {
  const cv::Mat3b image = cv::imread(path, cv::IMREAD_COLOR);
  if (image.empty()) throw std::runtime_error("cannot read image '" + path + "'");
  const std::int64_t before = cv::getTickCount();
  const Segmentation segmentation = segmenter.segment({{}, image, ColorOrder::kBgr, nullptr});
  const double seconds = static_cast<double>(cv::getTickCount() - before) / cv::getTickFrequency();
  cv::Mat3b drawn = drawSegments(image, segmentation);
  writeScores(segmentation, drawn);
  const fs::path target = output / (fs::path(path).stem().string() + ".png");
  if (!cv::imwrite(target.string(), drawn)) {
    throw std::runtime_error("cannot write '" + target.string() + "'");
  }
  std::printf("%s: %zu segments, %.0f ms\n", target.c_str(), segmentation.numSegments(),
              1e3 * seconds);
}

}  // namespace

int main(int argc, char** argv) try {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (std::find(words.begin(), words.end(), "--help") != words.end()) {
    printHelp();
    return 0;
  }
  const Arguments arguments = parse(words);
  segmentation::Segmenter segmenter(segmentation::loadModelSet(arguments.models), arguments.config);
  fs::create_directories(arguments.output);
  for (const std::string& image : arguments.images) segmentFile(image, arguments.output, segmenter);
  return 0;
} catch (const std::invalid_argument& e) {
  std::cerr << "segment_images: " << e.what() << '\n' << kUsage;
  return 2;
} catch (const std::exception& e) {
  std::cerr << "segment_images: " << e.what() << '\n';
  return 1;
}
