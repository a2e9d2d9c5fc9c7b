// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "task_scene_graph/config/visitor.h"

namespace tsg::segmentation {

/// The engine or a network file cannot be used; says which file, what was found and what was
/// expected.
class InferenceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Thrown out of a computation that another thread has cancelled.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("inference was cancelled") {}
};

/// Which hardware runs the networks. All but the CPU need an ONNX Runtime that was built for it.
enum class ExecutionProvider { kCpu, kCuda, kTensorRt };

struct EngineConfig {
  std::string library;
  ExecutionProvider provider = ExecutionProvider::kCpu;
  int device_id = 0;
  int num_threads = 0;
  bool allow_spinning = false;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("library", self.library, {}, "",
            "path of libonnxruntime.so; empty: $ONNXRUNTIME_LIBRARY, $ONNXRUNTIME_ROOT/lib, where "
            "scripts/install_engine put it, the system");
    v.choice("provider", self.provider,
             config::Choices<ExecutionProvider>{{"cpu", ExecutionProvider::kCpu},
                                                {"cuda", ExecutionProvider::kCuda},
                                                {"tensorrt", ExecutionProvider::kTensorRt}},
             "what runs the networks; cuda and tensorrt need an ONNX Runtime built for them");
    v.field("device_id", self.device_id, {0, 63}, "", "which GPU, for cuda and tensorrt");
    v.field("num_threads", self.num_threads, {0, 256}, "",
            "CPU threads of one network and of the work around it; 0: one per core");
    v.field("allow_spinning", self.allow_spinning, {}, "",
            "idle threads wait busily: a little faster alone, slower beside other work");
  }
};

/// A float32 tensor, row-major, whose values `owner` keeps alive (or the caller, if it is null).
/// Networks of half floats take and give these as well: values are converted.
struct TensorView {
  std::vector<std::int64_t> shape;
  const float* values = nullptr;  ///< null for an output of another element type
  std::shared_ptr<const void> owner;
};

/// An input of integers (std::int32_t or std::int64_t), row-major; the caller keeps them alive.
template <typename Integer>
struct IntegerTensorView {
  std::vector<std::int64_t> shape;
  const Integer* values = nullptr;
};

/// What one input of a network is given.
using InputTensor =
    std::variant<TensorView, IntegerTensorView<std::int64_t>, IntegerTensorView<std::int32_t>>;

/// An input or output of a network file.
struct TensorInfo {
  std::string name;
  std::string element_type;         ///< "float32", "int64", ...
  std::vector<std::int64_t> shape;  ///< -1 where the file leaves the size open
};

/// "[1,3,?,?]": a shape as messages write it.
std::string toText(const std::vector<std::int64_t>& shape);
/// "images float32[1,3,?,?]".
std::string toText(const TensorInfo& info);
/// Whether a TensorView can hold it: float32, or float16 that is converted.
bool isFloat(const TensorInfo& info);
/// All tensors of a list, joined by ", ".
std::string toText(const std::vector<TensorInfo>& infos);
/// The same with the shapes that a run gave: "output0 float32[1,37,8400], ...".
std::string toText(const std::vector<TensorInfo>& infos, const std::vector<TensorView>& views);

/// An ONNX file, ready to run. Thread safety: `run` and `cancel` may be called from any thread,
/// also at the same time.
class Network {
 public:
  /// Opens ONNX Runtime (once per process) and loads the file.
  /// @throws InferenceError if the library is not found or too old, the provider is missing from it
  /// (the message lists those present), or the file is absent or not a network.
  Network(const std::string& path, const EngineConfig& config);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  const std::string& path() const { return path_; }
  const std::vector<TensorInfo>& inputs() const { return inputs_; }
  const std::vector<TensorInfo>& outputs() const { return outputs_; }

  /// Runs a network of one float32 input; one view per output, in the file's order. The input is
  /// not copied, the outputs are owned by the views.
  /// @throws Cancelled after `cancel`; InferenceError if the run fails, naming the file and shapes.
  std::vector<TensorView> run(const TensorView& input) const;
  /// The same for any inputs, one for each that the file has, in its order and of its types.
  std::vector<TensorView> run(const std::vector<InputTensor>& inputs) const;

  /// Ends a running `run` within milliseconds; it and all later ones throw Cancelled.
  void cancel();
  bool isCancelled() const;

 private:
  struct Session;

  std::string path_;
  std::vector<TensorInfo> inputs_;
  std::vector<TensorInfo> outputs_;
  std::unique_ptr<Session> session_;
};

/// `config.num_threads`, or the number of cores where that is 0.
int resolveNumThreads(const EngineConfig& config);

}  // namespace tsg::segmentation
