// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/camera.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <tuple>

namespace tsg {
namespace {

void require(bool ok, const char* field, double value, const char* expected) {
  if (ok) return;
  std::ostringstream message;
  message << "camera intrinsics: " << field << " is " << value << ", expected " << expected;
  throw std::invalid_argument(message.str());
}

auto asTuple(const CameraModel& c) {
  return std::tie(c.width_px, c.height_px, c.fx_px, c.fy_px, c.cx_px, c.cy_px);
}

}  // namespace

void CameraModel::validate() const {
  require(width_px > 0, "width", width_px, "a positive number of pixels");
  require(height_px > 0, "height", height_px, "a positive number of pixels");
  require(std::isfinite(fx_px) && fx_px > 0.0, "fx (K[0])", fx_px, "a positive, finite number");
  require(std::isfinite(fy_px) && fy_px > 0.0, "fy (K[4])", fy_px, "a positive, finite number");
  require(std::isfinite(cx_px), "cx (K[2])", cx_px, "a finite number");
  require(std::isfinite(cy_px), "cy (K[5])", cy_px, "a finite number");
}

bool operator==(const CameraModel& a, const CameraModel& b) { return asTuple(a) == asTuple(b); }

}  // namespace tsg
