// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "task_scene_graph/core/files.h"

namespace tsg::ros_interface {

/// What a stage leaves behind when it ends.
struct EndReport {
  std::string stage;               ///< its node name, for messages
  std::filesystem::path folder;    ///< empty: no output was asked for
  std::vector<WrittenFile> files;  ///< in `folder`
  std::string reason;   ///< why there are none, where it is known: "no frame was ever usable (...)"
  std::string problem;  ///< what went wrong while they were written, or ""

  bool isMissing() const { return !folder.empty() && (files.empty() || !problem.empty()); }
};

/// The line for what some stages, in the order of the chain, leave behind: "wrote FOLDER: ...", or
/// "no map was written: " and the first reason there is. "" where no output was asked for.
std::string describeEnd(const std::vector<EndReport>& reports);

/// Hands over a stage's last words: logged at once, or kept for the program's own line while an
/// EndGatherer lives in this process. Thread-safe.
void reportEnd(const EndReport& report);

/// While it lives, this process' stages are silent at their end, and the program says one line for
/// all of them. One at a time.
class EndGatherer {
 public:
  EndGatherer();
  ~EndGatherer();
  EndGatherer(const EndGatherer&) = delete;
  EndGatherer& operator=(const EndGatherer&) = delete;

  /// What was reported so far, the stage that ended last first: stages end against the order of
  /// the chain.
  std::vector<EndReport> collect();
};

}  // namespace tsg::ros_interface
