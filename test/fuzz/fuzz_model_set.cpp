// SPDX-License-Identifier: BSD-3-Clause
// Model sets whose files are there, and every number of which is then fit to be used.
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "fuzzer.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace {

namespace fuzz = tsg::fuzz;

std::string makeModelSet() {
  std::ostringstream text;
  tsg::segmentation::ModelSet models;
  models.name = "small";
  models.segmenter = "segmenter.onnx";
  models.image_encoder = "encoder.onnx";
  models.tokenizer = "vocabulary.txt";
  models.embedding_size = 4;
  text << tsg::config::toYaml(models) << '\n';
  return text.str();
}

std::string make(fuzz::Mutator& mutator) {
  static const std::string corpus = makeModelSet();
  return fuzz::makeYaml(mutator, corpus);
}

void readInput(const std::string& path) {
  const auto models = tsg::segmentation::loadModelSet(path);
  const auto isFinite = [](double value) { return std::isfinite(value); };
  const bool is_usable =
      std::all_of(models.image_mean.begin(), models.image_mean.end(), isFinite) &&
      std::all_of(models.image_std.begin(), models.image_std.end(), isFinite) &&
      isFinite(models.alpha) && models.embedding_size > 0;
  if (!is_usable) throw std::logic_error("accepts a number that cannot be used");
}

}  // namespace

int main(int argc, char** argv) {
  for (const char* name : {"segmenter.onnx", "encoder.onnx", "vocabulary.txt"}) {
    fuzz::writeFile(fuzz::scratchFolder() / name, "here");
  }
  return fuzz::runFuzzer(argc, argv,
                         fuzz::makeFileReader("model_set", "models.yaml", make, readInput));
}
