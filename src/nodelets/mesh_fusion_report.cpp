// SPDX-License-Identifier: BSD-3-Clause
#include "mesh_fusion_report.h"

#include <string>

namespace tsg::nodelets {

void reportBackground(const pipeline::BackgroundFusion& background,
                      ros_interface::StageReport& report) {
  const auto& counters = background.surface.counters();
  report.set("frames without depth in range", std::to_string(counters.frames_without_depth));
  report.set("jumps of the camera", std::to_string(counters.pose_jumps));
  report.set("blocks archived", std::to_string(counters.blocks_archived));
  report.set("depth readings rejected by the filter",
             std::to_string(background.depth_filter.counters().rejected_readings));
}

void reportObjects(const pipeline::ObjectFusion& objects, ros_interface::StageReport& report) {
  for (const auto& [reason, count] : objects.rejections()) {
    report.set("tracks without an object: " + reason, std::to_string(count));
  }
  report.set("tracks that wait for reconstruction", std::to_string(objects.numPending()));
  report.set("frames evicted from the full frame buffer",
             std::to_string(objects.frameCounters().evicted));
  report.set("MB of frames kept for objects", std::to_string(objects.aliveBytes() / 1000000U));
}

}  // namespace tsg::nodelets
