// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/input_plausibility_report.h"

namespace tsg::ros_interface {

void InputPlausibilityReport::addFrame(const RgbdFrame& frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  checks_.addFrame(frame);
}

std::map<std::string, std::string> InputPlausibilityReport::makeReport(
    const FrameAssembler::Counters& counters, const FrameAssembler::FrameIds& ids) {
  plausibility::MatchCounts matches;
  matches.color_images = counters.colors;
  matches.unmatched = counters.unmatched_colors;
  matches.nearest_unmatched_s = counters.nearest_unmatched_s;
  matches.tolerance_s = sync_tolerance_s_;
  const std::lock_guard<std::mutex> lock(mutex_);
  checks_.noteMatches(matches);
  checks_.noteFrameIds({ids.color, ids.depth, ids.camera_info});
  std::map<std::string, std::string> lines;
  for (const auto& finding : checks_.findings()) {
    lines.emplace(finding.check, plausibility::toText(finding));
  }
  return lines;
}

}  // namespace tsg::ros_interface
