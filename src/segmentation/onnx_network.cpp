// SPDX-License-Identifier: BSD-3-Clause
#include "onnx_runtime.h"

#ifdef TSG_WITH_ONNXRUNTIME

#include <Eigen/Core>
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <utility>

#include "task_scene_graph/core/file_kind.h"
#include "task_scene_graph/segmentation/inference_engine.h"

namespace tsg::segmentation {
namespace {

const char* toProviderName(ExecutionProvider provider) {
  switch (provider) {
    case ExecutionProvider::kCuda:
      return "CUDAExecutionProvider";
    case ExecutionProvider::kTensorRt:
      return "TensorrtExecutionProvider";
    case ExecutionProvider::kCpu:
      break;
  }
  return "CPUExecutionProvider";
}

void requireProvider(const char* wanted) {
  const std::vector<std::string> present = Ort::GetAvailableProviders();
  if (std::find(present.begin(), present.end(), wanted) != present.end()) return;
  std::string names;
  for (const auto& name : present) names += (names.empty() ? "" : ", ") + name;
  throw InferenceError(std::string("this ONNX Runtime has no ") + wanted + ", only " + names +
                       " (parameter engine/provider)");
}

void appendProvider(Ort::SessionOptions& options, const EngineConfig& config) {
  requireProvider(toProviderName(config.provider));
  if (config.provider == ExecutionProvider::kTensorRt) {
    OrtTensorRTProviderOptions tensorrt{};
    tensorrt.device_id = config.device_id;
    options.AppendExecutionProvider_TensorRT(tensorrt);
  }
  if (config.provider != ExecutionProvider::kCpu) {  // also what TensorRT leaves over
    OrtCUDAProviderOptions cuda{};
    cuda.device_id = config.device_id;
    options.AppendExecutionProvider_CUDA(cuda);
  }
}

Ort::SessionOptions makeOptions(const EngineConfig& config) {
  Ort::SessionOptions options;
  options.SetIntraOpNumThreads(resolveNumThreads(config));
  options.SetInterOpNumThreads(1);
  options.AddConfigEntry("session.intra_op.allow_spinning", config.allow_spinning ? "1" : "0");
  appendProvider(options, config);
  return options;
}

std::string toTypeName(ONNXTensorElementDataType type) {
  static const char* const kNames[] = {"undefined", "float32", "uint8",  "int8",   "uint16",
                                       "int16",     "int32",   "int64",  "string", "bool",
                                       "float16",   "float64", "uint32", "uint64"};
  const auto index = static_cast<std::size_t>(type);
  return index < std::size(kNames) ? kNames[index] : "type " + std::to_string(index);
}

TensorInfo describeTensor(std::string name, const Ort::TypeInfo& type) {
  if (type.GetONNXType() != ONNX_TYPE_TENSOR) return {std::move(name), "not a tensor", {}};
  const auto tensor = type.GetTensorTypeAndShapeInfo();
  return {std::move(name), toTypeName(tensor.GetElementType()), tensor.GetShape()};
}

std::vector<TensorInfo> describeInputs(const Ort::Session& session) {
  Ort::AllocatorWithDefaultOptions allocator;
  std::vector<TensorInfo> infos;
  for (std::size_t i = 0; i < session.GetInputCount(); ++i) {
    infos.push_back(describeTensor(session.GetInputNameAllocated(i, allocator).get(),
                                   session.GetInputTypeInfo(i)));
  }
  return infos;
}

std::vector<TensorInfo> describeOutputs(const Ort::Session& session) {
  Ort::AllocatorWithDefaultOptions allocator;
  std::vector<TensorInfo> infos;
  for (std::size_t i = 0; i < session.GetOutputCount(); ++i) {
    infos.push_back(describeTensor(session.GetOutputNameAllocated(i, allocator).get(),
                                   session.GetOutputTypeInfo(i)));
  }
  return infos;
}

/// What an input takes; a size that the file leaves open counts as much as the largest, but for the
/// first, the batch's.
double countInputValues(const std::vector<std::int64_t>& shape) {
  if (shape.empty()) return 1.0;
  const auto largest = static_cast<double>(*std::max_element(shape.begin(), shape.end()));
  double count = shape[0] > 0 ? static_cast<double>(shape[0]) : 1.0;
  for (std::size_t i = 1; i < shape.size(); ++i) {
    count *= shape[i] > 0 ? static_cast<double>(shape[i]) : std::max(largest, 1.0);
  }
  return count;
}

/// A damaged file may ask for terabytes.
void checkInputSizes(const std::string& path, const std::vector<TensorInfo>& inputs) {
  constexpr double kMostValues = 1 << 28;  // 256 images of 512 x 512 pixels, 1 GB
  for (const auto& input : inputs) {
    if (countInputValues(input.shape) <= kMostValues) continue;
    throw InferenceError("network file '" + path + "' has an input " + toText(input) +
                         ", expected one of at most 2^28 values; the file is damaged, or made for "
                         "another purpose");
  }
}

TensorView toView(Ort::Value&& value) {
  const auto owner = std::make_shared<const Ort::Value>(std::move(value));
  const auto info = owner->GetTensorTypeAndShapeInfo();
  if (info.GetElementType() == ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT16) {
    const auto* halves = reinterpret_cast<const Eigen::half*>(owner->GetTensorRawData());
    const auto floats = std::make_shared<std::vector<float>>(info.GetElementCount());
    std::transform(halves, halves + floats->size(), floats->begin(),
                   [](Eigen::half half) { return static_cast<float>(half); });
    return {info.GetShape(), floats->data(), floats};
  }
  const bool is_float = info.GetElementType() == ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT;
  return {info.GetShape(), is_float ? owner->GetTensorData<float>() : nullptr, owner};
}

std::size_t countValues(const std::vector<std::int64_t>& shape) {
  std::size_t count = 1;
  for (const std::int64_t size : shape) count *= static_cast<std::size_t>(size);
  return count;
}

template <typename T>
Ort::Value wrapValues(const std::vector<std::int64_t>& shape, const T* values) {
  const auto memory = Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
  // ONNX Runtime takes inputs as mutable but does not write to them.
  return Ort::Value::CreateTensor<T>(memory, const_cast<T*>(values), countValues(shape),
                                     shape.data(), shape.size());
}

using Halves = std::vector<Eigen::half>;

/// `halves` keeps what has to be converted.
Ort::Value wrapInput(const TensorView& input, const TensorInfo& info, Halves& halves) {
  if (info.element_type != "float16") return wrapValues(input.shape, input.values);
  halves.resize(countValues(input.shape));
  std::transform(input.values, input.values + halves.size(), halves.begin(),
                 [](float value) { return Eigen::half(value); });
  return wrapValues(input.shape, reinterpret_cast<const Ort::Float16_t*>(halves.data()));
}

template <typename Integer>
Ort::Value wrapInput(const IntegerTensorView<Integer>& input, const TensorInfo&, Halves&) {
  return wrapValues(input.shape, input.values);
}

std::string describeShapes(const std::vector<InputTensor>& inputs) {
  std::string text;
  for (const InputTensor& input : inputs) {
    const auto toShape = [](const auto& view) { return toText(view.shape); };
    text += (text.empty() ? "" : " and ") + std::visit(toShape, input);
  }
  return text;
}

std::vector<const char*> namesOf(const std::vector<TensorInfo>& infos) {
  std::vector<const char*> names;
  for (const auto& info : infos) names.push_back(info.name.c_str());
  return names;
}

}  // namespace

struct Network::Session {
  Ort::Session session{nullptr};
  mutable Ort::RunOptions run_options{nullptr};  // shared by all runs, so that one flag ends them
  std::atomic<bool> cancelled{false};
};

Network::Network(const std::string& path, const EngineConfig& config) : path_(path) {
  Ort::Env& environment = openOnnxRuntime(config.library);
  session_ = std::make_unique<Session>();  // not earlier: even an empty one needs the library
  if (!std::filesystem::is_regular_file(path)) {
    throw InferenceError("network file '" + path + "' is not there");
  }
  try {
    session_->session = Ort::Session(environment, path.c_str(), makeOptions(config));
    session_->run_options = Ort::RunOptions();
    inputs_ = describeInputs(session_->session);
    outputs_ = describeOutputs(session_->session);
    checkInputSizes(path, inputs_);
  } catch (const Ort::Exception& e) {
    const std::string kind = describeFileKind(path);
    throw InferenceError("network file '" + path + "' cannot be loaded: " +
                         (kind.empty() ? e.what()
                                       : "it " + kind +
                                             "; expected an ONNX file, such "
                                             "as scripts/export_models makes"));
  }
}

Network::~Network() = default;

std::vector<TensorView> Network::run(const std::vector<InputTensor>& inputs) const {
  if (isCancelled()) throw Cancelled();
  std::vector<Halves> halves(inputs.size());
  try {
    std::vector<Ort::Value> values;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      const auto wrap = [&](const auto& view) { return wrapInput(view, inputs_.at(i), halves[i]); };
      values.push_back(std::visit(wrap, inputs[i]));
    }
    const std::vector<const char*> input_names = namesOf(inputs_);
    const std::vector<const char*> output_names = namesOf(outputs_);
    std::vector<Ort::Value> results =
        session_->session.Run(session_->run_options, input_names.data(), values.data(),
                              values.size(), output_names.data(), output_names.size());
    std::vector<TensorView> views;
    for (auto& output : results) views.push_back(toView(std::move(output)));
    return views;
  } catch (const Ort::Exception& e) {
    if (isCancelled()) throw Cancelled();
    throw InferenceError("network '" + path_ + "' failed on an input " + describeShapes(inputs) +
                         ", it has " + toText(inputs_) + ": " + e.what());
  }
}

std::vector<TensorView> Network::run(const TensorView& input) const {
  return run(std::vector<InputTensor>{input});
}

void Network::cancel() {
  session_->cancelled = true;
  session_->run_options.SetTerminate();
}

bool Network::isCancelled() const { return session_->cancelled; }

}  // namespace tsg::segmentation

#endif
