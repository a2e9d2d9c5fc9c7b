// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "support.h"
#include "task_scene_graph/segmentation/inference_engine.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace tsg::segmentation {

/// A network written by test/data/networks/make_networks.py.
inline std::string findNetwork(const std::string& name) {
  return std::string(TSG_SOURCE_DIR) + "/test/data/networks/" + name + ".onnx";
}

/// The small segmenter (red, green and blue regions) and the small encoder (mean colour).
inline ModelSet makeSmallModels() {
  ModelSet models;
  models.name = "small";
  models.segmenter = findNetwork("segmenter");
  models.segmenter_score_threshold = 0.25;
  models.segmenter_iou_threshold = 0.99;  // their boxes differ little
  models.segmenter_input_size_px = 64;
  models.image_encoder = findNetwork("encoder");
  models.image_encoder_input_size_px = 8;
  models.embedding_size = 4;
  models.image_mean = {0.5, 0.4, 0.3};
  models.image_std = {0.2, 0.3, 0.4};
  return models;
}

/// Why networks cannot run here: ONNX Runtime is not installed. Empty if they can.
inline std::string findEngineObstacle() {
  try {
    const Network network(findNetwork("encoder"), {});
    return "";
  } catch (const InferenceError& e) {
    const std::string what = e.what();
    const bool is_absent = what.find("built without ONNX Runtime") != std::string::npos ||
                           what.find("ONNX Runtime cannot be opened") != std::string::npos;
    if (is_absent) return what;
    throw;
  }
}

}  // namespace tsg::segmentation

/// Skips the running test where ONNX Runtime is not installed.
#define TSG_REQUIRE_ENGINE()                                              \
  do {                                                                    \
    const std::string obstacle = tsg::segmentation::findEngineObstacle(); \
    if (!obstacle.empty()) GTEST_SKIP() << obstacle;                      \
  } while (false)
