// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#ifdef TSG_WITH_ONNXRUNTIME

#define ORT_API_MANUAL_INIT  // the library is opened by hand, nothing links to it
#include <onnxruntime_cxx_api.h>
#undef ORT_API_MANUAL_INIT

#include <string>

namespace tsg::segmentation {

/// Opens ONNX Runtime at the first call; one library serves the whole process and is never closed.
/// @param library path, or "" for the known places.
/// @throws InferenceError listing where it was looked for, or if another one is already open.
Ort::Env& openOnnxRuntime(const std::string& library);

}  // namespace tsg::segmentation

#endif
