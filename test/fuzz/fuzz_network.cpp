// SPDX-License-Identifier: BSD-3-Clause
// Network files, loaded and tried as segmenter and as image encoder. Needs ONNX Runtime.
#include <iostream>
#include <stdexcept>

#include "fuzzer.h"
#include "task_scene_graph/segmentation/image_encoder.h"
#include "task_scene_graph/segmentation/segmenter.h"

namespace {

namespace fuzz = tsg::fuzz;
namespace segmentation = tsg::segmentation;

std::string findNetwork(const std::string& name) {
  return std::string(TSG_SOURCE_DIR) + "/test/data/networks/" + name + ".onnx";
}

std::string make(fuzz::Mutator& mutator) {
  static const std::vector<std::string> corpus{
      fuzz::readFile(findNetwork("segmenter")), fuzz::readFile(findNetwork("segmenter_nms")),
      fuzz::readFile(findNetwork("segmenter_open_size")), fuzz::readFile(findNetwork("encoder")),
      fuzz::readFile(findNetwork("encoder_open_size"))};
  static const std::vector<std::string> words{"Conv", "Gemm", "Reshape", "output0", "images"};
  std::string network = mutator.pickFrom(corpus);
  mutator.mutateBytes(words, network);
  return network;
}

segmentation::ModelSet makeModels(const std::string& path) {
  segmentation::ModelSet models;
  models.name = "fuzzed";
  models.segmenter = models.image_encoder = path;
  models.segmenter_input_size_px = 64;
  models.segmenter_score_threshold = 0.25;
  models.image_encoder_input_size_px = 8;
  models.embedding_size = 4;
  return models;
}

tsg::ColorImage makeImage() {
  tsg::ColorImage color;
  color.image = cv::Mat(48, 64, CV_8UC3, cv::Scalar(30, 30, 30));
  color.image.colRange(10, 30).setTo(cv::Scalar(200, 40, 40));
  return color;
}

void segment(const std::string& path) {
  segmentation::SegmenterConfig config;
  config.engine.num_threads = 1;
  config.embed_crop = config.embed_masked_crop = config.embed_image = false;
  segmentation::Segmenter(makeModels(path), config).segment(makeImage()).validate();
}

void encode(const std::string& path) {
  segmentation::EngineConfig engine;
  engine.num_threads = 1;
  segmentation::ImageEncoder(makeModels(path), engine, {})
      .encode(makeImage(), {}, {{cv::Rect(5, 5, 20, 20), 0}});
}

/// As a segmenter, then as an encoder.
void readInput(const std::string& path) {
  try {
    segment(path);
    return;  // no network is both
  } catch (const segmentation::InferenceError& e) {
    if (std::string(e.what()).find(path) == std::string::npos) throw;
  }
  encode(path);
}

bool isEngineThere() {
  try {
    const segmentation::Network network(findNetwork("encoder"), {});
    return true;
  } catch (const segmentation::InferenceError& e) {
    std::cout << "fuzz_network: skipped: " << e.what() << '\n';
    return false;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (!isEngineThere()) return 0;
  return fuzz::runFuzzer(argc, argv, fuzz::makeFileReader("network", "network.onnx", make, readInput));
}
