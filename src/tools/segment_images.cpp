// SPDX-License-Identifier: BSD-3-Clause
// Draws the segments that a model set finds over images, to see what its thresholds do.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/config/config_file.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/segmentation/model_set.h"
#include "task_scene_graph/segmentation/overlay.h"
#include "task_scene_graph/segmentation/segmenter.h"

namespace fs = std::filesystem;
using namespace tsg;

namespace {

constexpr const char* kUsage =
    "usage: segment_images --models M.yaml --output DIR [options] IMAGE...\n"
    "Draws the segments found in each image over it and writes DIR/<image name>.png.\n"
    "  --config C.yaml         parameters of the segmenter (below)\n"
    "  --score-threshold X     in place of the model set's\n"
    "  --iou-threshold X       in place of the model set's\n"
    "  --embed                 also embed the segments, to see how long that takes\n"
    "  --data                  also embed, and write DIR/<image name>.labels.png (16 bit) and "
    ".json\n"
    "                          (scores, embeddings, image_embedding)\n"
    "  --help                  this text and the parameters\n";

struct Arguments {
  std::string models;
  std::string output;
  std::vector<std::string> images;
  bool write_data = false;
  segmentation::SegmenterConfig config;
};

void printHelp() {
  std::cout << kUsage << "parameters:\n";
  for (const auto& row : config::describe<segmentation::SegmenterConfig>()) {
    std::cout << "  " << row.name << " (" << row.default_value << "): " << row.doc << '\n';
  }
}

/// The command line as it was typed: values of options (empty if not given) and image files.
struct Words {
  std::map<std::string, std::string> options{{"--models", ""},
                                             {"--output", ""},
                                             {"--config", ""},
                                             {"--score-threshold", ""},
                                             {"--iou-threshold", ""}};
  bool embed = false;
  bool write_data = false;
  std::vector<std::string> images;
};

Words sortWords(const std::vector<std::string>& line) {
  Words words;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const auto option = words.options.find(line[i]);
    if (option != words.options.end()) {
      if (i + 1 == line.size()) throw std::invalid_argument(line[i] + " needs a value");
      option->second = line[++i];
    } else if (line[i] == "--embed") {
      words.embed = true;
    } else if (line[i] == "--data") {
      words.embed = words.write_data = true;
    } else if (line[i].rfind("--", 0) == 0) {
      throw std::invalid_argument("unknown option " + line[i]);
    } else {
      words.images.push_back(line[i]);
    }
  }
  return words;
}

void overrideThreshold(const Words& words, const std::string& option, double& value) {
  const std::string& text = words.options.at(option);
  if (text.empty()) return;
  const auto number = config::parseNumber(text);
  if (!number) throw std::invalid_argument(option + " is '" + text + "', expected a number");
  value = *number;
}

/// The parameters alone, or a whole configuration file with a section `segmenter`.
segmentation::SegmenterConfig readConfig(const fs::path& path) {
  const YAML::Node file = config::loadYamlFile(path.string());
  const auto& stages = config::listStages();
  const bool is_whole = file.IsMap() && std::any_of(stages.begin(), stages.end(), [&](auto& stage) {
                          return file[stage].IsDefined();
                        });
  const config::Source alone{"file '" + path.string() + "'", file, path.parent_path()};
  if (!is_whole) return config::load<segmentation::SegmenterConfig>({alone}, "parameters");
  config::Source section =
      config::splitConfig(config::readConfigFile(path), "segmenter", {}).back();
  for (const char* name : {"models", "input", "patience_s", "diagnostic_period"}) {
    if (section.parameters.IsMap()) section.parameters.remove(name);  // the nodelet's own
  }
  return config::load<segmentation::SegmenterConfig>({section}, "parameters");
}

segmentation::SegmenterConfig makeConfig(const Words& words) {
  segmentation::SegmenterConfig config;
  const std::string& path = words.options.at("--config");
  if (!path.empty()) {
    config = readConfig(expandPath(path));
  }
  overrideThreshold(words, "--score-threshold", config.score_threshold);
  overrideThreshold(words, "--iou-threshold", config.iou_threshold);
  if (!words.embed) config.embed_crop = config.embed_masked_crop = config.embed_image = false;
  return config;
}

Arguments parse(const std::vector<std::string>& line) {
  const Words words = sortWords(line);
  for (const char* required : {"--models", "--output"}) {
    if (words.options.at(required).empty()) {
      throw std::invalid_argument(std::string(required) + " is missing");
    }
  }
  if (words.images.empty()) throw std::invalid_argument("no image given");
  std::vector<std::string> images;
  for (const auto& image : words.images) images.push_back(expandPath(image).string());
  return {expandPath(words.options.at("--models")).string(),
          expandPath(words.options.at("--output")).string(), images, words.write_data,
          makeConfig(words)};
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

void writeImage(const fs::path& path, const cv::Mat& image) {
  if (!cv::imwrite(path.string(), image)) {
    throw std::runtime_error("cannot write '" + path.string() + "'");
  }
}

std::vector<float> toVector(const Embedding& embedding) {
  return {embedding.data(), embedding.data() + embedding.size()};
}

void writeData(const fs::path& stem, const Segmentation& segmentation) {
  writeImage(stem.string() + ".labels.png", segmentation.labels);
  nlohmann::json data{{"scores", segmentation.confidences},
                      {"embeddings", nlohmann::json::array()},
                      {"image_embedding", toVector(segmentation.image_embedding)}};
  for (Eigen::Index i = 0; i < segmentation.embeddings.rows(); ++i) {
    data["embeddings"].push_back(toVector(segmentation.embeddings.row(i).transpose()));
  }
  writeFileAtomically(stem.string() + ".json", [&](std::ostream& out) { out << data << '\n'; });
}

std::size_t segmentFile(const std::string& path, const Arguments& arguments,
                        segmentation::Segmenter& segmenter) {
  const cv::Mat3b image = cv::imread(path, cv::IMREAD_COLOR);
  if (image.empty()) throw std::runtime_error("cannot read image '" + path + "'");
  const std::int64_t before = cv::getTickCount();
  const Segmentation segmentation = segmenter.segment({{}, image, ColorOrder::kBgr, nullptr});
  const double seconds = static_cast<double>(cv::getTickCount() - before) / cv::getTickFrequency();
  cv::Mat3b drawn = segmentation::drawSegments(image, segmentation.labels, ColorOrder::kBgr);
  writeScores(segmentation, drawn);
  const fs::path stem = fs::path(arguments.output) / fs::path(path).stem();
  const fs::path target = stem.string() + ".png";
  writeImage(target, drawn);
  if (arguments.write_data) writeData(stem, segmentation);
  std::printf("%s: %zu segments, %.0f ms\n", target.c_str(), segmentation.numSegments(),
              1e3 * seconds);
  return segmentation.numSegments();
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
  std::size_t num_segments = 0;
  for (const auto& image : arguments.images)
    num_segments += segmentFile(image, arguments, segmenter);
  const std::string content = formatCount(num_segments, "segment");
  const std::string files = formatCount(arguments.images.size(), "drawn image") +
                            (arguments.write_data ? ", labels and data" : "");
  std::printf("%s\n", describeWritten(arguments.output, {{files, content}}).c_str());
  return 0;
} catch (const std::invalid_argument& e) {
  std::cerr << "segment_images: " << e.what() << '\n' << kUsage;
  return 2;
} catch (const std::exception& e) {
  std::cerr << "segment_images: " << e.what() << '\n';
  return 1;
}
