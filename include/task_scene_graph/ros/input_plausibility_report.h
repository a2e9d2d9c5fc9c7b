// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "task_scene_graph/plausibility/input_plausibility.h"
#include "task_scene_graph/ros/frame_assembler.h"

namespace tsg::ros_interface {

/// The plausibility report on what a FrameAssembler has put together, for live topics and bags
/// alike. Thread-safe.
class InputPlausibilityReport {
 public:
  InputPlausibilityReport(const plausibility::PlausibilityConfig& config, double sync_tolerance_s)
      : sync_tolerance_s_(sync_tolerance_s), checks_(config) {}

  /// A frame with its pose.
  void addFrame(const RgbdFrame& frame);
  /// One line for each thing that looks wrong, by key. May take 60 ms.
  std::map<std::string, std::string> makeReport(const FrameAssembler::Counters& counters,
                                                const FrameAssembler::FrameIds& ids);

 private:
  const double sync_tolerance_s_;
  std::mutex mutex_;  ///< guards checks_
  plausibility::InputPlausibility checks_;
};

}  // namespace tsg::ros_interface
