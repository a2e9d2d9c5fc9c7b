// SPDX-License-Identifier: BSD-3-Clause
// Network files, loaded as segmenter and as image encoder. Needs ONNX Runtime.
#include <iostream>
#include <stdexcept>

#include "fuzzer.h"
#include "task_scene_graph/segmentation/clip_tower.h"
#include "task_scene_graph/segmentation/segmenter_layout.h"

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

/// As a segmenter, then as an image encoder, up to the first run: what a damaged network computes
/// is ONNX Runtime's to bear, and some loop there for ever.
void readInput(const std::string& path) {
  segmentation::EngineConfig engine;
  engine.num_threads = 1;
  const segmentation::Network network(path, engine);
  segmentation::explainSegmenterInputs(network.inputs());
  segmentation::ModelSet models;
  models.name = "fuzzed";
  models.image_encoder = path;
  models.image_encoder_input_size_px = 8;
  models.embedding_size = 4;
  const segmentation::ClipTower tower(segmentation::Modality::kImage, models, engine);
  if (tower.inputSize() <= 0) throw std::logic_error("accepts images without pixels");
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
  return fuzz::runFuzzer(argc, argv,
                         fuzz::makeFileReader("network", "network.onnx", make, readInput));
}
