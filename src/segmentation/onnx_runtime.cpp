// SPDX-License-Identifier: BSD-3-Clause
#include "onnx_runtime.h"

#ifdef TSG_WITH_ONNXRUNTIME

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <vector>

#include "task_scene_graph/core/files.h"
#include "task_scene_graph/segmentation/inference_engine.h"

namespace tsg::segmentation {
namespace {

constexpr int kOldestInterface = 14;  // the first with all that is used here (ONNX Runtime 1.14)

struct OpenLibrary {
  std::string path;
  Ort::Env environment{nullptr};
};

std::string getVariable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::vector<std::string> listKnownPlaces() {
  std::vector<std::string> places;
  const auto add = [&](const std::string& folder, const std::string& below) {
    if (!folder.empty()) places.push_back(folder + below);
  };
  add(getVariable("ONNXRUNTIME_LIBRARY"), "");
  add(getVariable("ONNXRUNTIME_ROOT"), "/lib/libonnxruntime.so");
  add(TSG_ONNXRUNTIME_HOME, "/lib/libonnxruntime.so");
  const std::string in_cache = "/task_scene_graph/onnxruntime/lib/libonnxruntime.so";
  add(getVariable("XDG_CACHE_HOME"), in_cache);
  add(getVariable("HOME"), "/.cache" + in_cache);
  places.emplace_back("libonnxruntime.so.1");
  places.emplace_back("libonnxruntime.so");
  return places;
}

void* openFirst(const std::vector<std::string>& places, std::string& opened) {
  std::string tried;
  for (const std::string& place : places) {
    if (void* handle = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL)) {
      opened = place;
      return handle;
    }
    tried += std::string("\n  ") + dlerror();
  }
  throw InferenceError(
      "ONNX Runtime cannot be opened; run scripts/install_engine, or set the parameter "
      "engine/library or ONNXRUNTIME_ROOT. Tried:" +
      tried);
}

// A library knows all interfaces up to its own minor version; older ones than our headers will do.
const OrtApi* getInterface(void* handle, const std::string& path) {
  using GetApiBase = const OrtApiBase* (*)();
  const auto get_base = reinterpret_cast<GetApiBase>(dlsym(handle, "OrtGetApiBase"));
  if (get_base == nullptr) throw InferenceError("'" + path + "' is not ONNX Runtime");
  const std::string version = get_base()->GetVersionString();
  const std::size_t dot = version.find('.');
  const int minor = dot == std::string::npos ? 0 : std::atoi(version.c_str() + dot + 1);
  const int known = std::min(minor, ORT_API_VERSION);
  const OrtApi* api =
      known < kOldestInterface ? nullptr : get_base()->GetApi(static_cast<std::uint32_t>(known));
  if (api != nullptr) return api;
  throw InferenceError("ONNX Runtime '" + path + "' has version " + version +
                       ", expected 1.14 or newer");
}

/// A path as people write it; a bare name is left to the dynamic loader.
std::string expandLibrary(const std::string& library) {
  return library.find_first_of("/~$") == std::string::npos ? library : expandPath(library).string();
}

void ignoreMessage(void*, OrtLoggingLevel, const char*, const char*, const char*, const char*) {}

}  // namespace

Ort::Env& openOnnxRuntime(const std::string& name) {
  const std::string library = expandLibrary(name);
  static std::mutex mutex;
  static OpenLibrary* open = nullptr;  // never freed: sessions may outlive any static object
  const std::lock_guard<std::mutex> lock(mutex);
  if (open == nullptr) {
    std::string path;
    void* handle =
        openFirst(library.empty() ? listKnownPlaces() : std::vector<std::string>{library}, path);
    Ort::InitApi(getInterface(handle, path));
    // Whatever goes wrong comes back as an exception; the library itself prints nothing.
    Ort::Env environment(ORT_LOGGING_LEVEL_FATAL, "task_scene_graph", ignoreMessage, nullptr);
    open = new OpenLibrary{path, std::move(environment)};
  }
  if (!library.empty() && library != open->path) {
    throw InferenceError("ONNX Runtime '" + open->path + "' is already open in this process, '" +
                         library + "' cannot be opened beside it");
  }
  return open->environment;
}

}  // namespace tsg::segmentation

#endif
