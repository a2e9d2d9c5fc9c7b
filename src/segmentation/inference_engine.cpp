// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/inference_engine.h"

#include <algorithm>
#include <thread>

namespace tsg::segmentation {

std::string toText(const std::vector<std::int64_t>& shape) {
  std::string text;
  for (const std::int64_t size : shape) {
    text += (text.empty() ? "" : ",") + (size < 0 ? "?" : std::to_string(size));
  }
  return '[' + text + ']';
}

std::string toText(const TensorInfo& info) {
  return info.name + ' ' + info.element_type + toText(info.shape);
}

bool isFloat(const TensorInfo& info) {
  return info.element_type == "float32" || info.element_type == "float16";
}

std::string toText(const std::vector<TensorInfo>& infos) {
  std::string text;
  for (const auto& info : infos) text += (text.empty() ? "" : ", ") + toText(info);
  return text;
}

std::string toText(const std::vector<TensorInfo>& infos, const std::vector<TensorView>& views) {
  std::string text;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const TensorInfo& info = infos.at(i);
    text += (text.empty() ? "" : ", ") +
            toText(TensorInfo{info.name, info.element_type, views[i].shape});
  }
  return text;
}

int resolveNumThreads(const EngineConfig& config) {
  if (config.num_threads > 0) return config.num_threads;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace tsg::segmentation
