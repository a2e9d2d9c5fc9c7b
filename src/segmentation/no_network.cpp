// SPDX-License-Identifier: BSD-3-Clause
// Stands in for onnx_network.cpp where the package was built without ONNX Runtime's headers.
#ifndef TSG_WITH_ONNXRUNTIME

#include "task_scene_graph/segmentation/inference_engine.h"

namespace tsg::segmentation {

struct Network::Session {};

Network::Network(const std::string& path, const EngineConfig&) : path_(path) {
  throw InferenceError("network file '" + path +
                       "' cannot be run: this program was built without ONNX Runtime; run "
                       "scripts/install_engine and build again");
}

Network::~Network() = default;
std::vector<TensorView> Network::run(const TensorView&) const { return {}; }
std::vector<TensorView> Network::run(const std::vector<InputTensor>&) const { return {}; }
void Network::cancel() {}
bool Network::isCancelled() const { return false; }

}  // namespace tsg::segmentation

#endif
