// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "task_scene_graph/ros/log_throttle.h"

namespace tsg::ros_interface {

/// What a stage did so far: counters for /diagnostics, and problems for the log. All functions may
/// be called from any thread.
class StageReport {
 public:
  explicit StageReport(std::string name) : name_(std::move(name)) {}

  void countInput();
  void countProcessed(double duration_ms);
  /// `problem`, if given, is logged as a warning, as often as LogThrottle says for its reason, and
  /// shown in diagnostics.
  void countDropped(const std::string& reason, const std::string& problem = "",
                    std::uint64_t count = 1);
  /// `is_shared`: the stage reads the pixels of the message itself; else it made a copy.
  void countImage(bool is_shared, const void* pixels);
  /// Logs a problem that drops nothing; throttled by `key` as above.
  void warn(const std::string& key, const std::string& problem);
  /// What looks wrong with the input at present, by key: shown in diagnostics, which then say WARN;
  /// each key is logged once.
  void setFindings(std::map<std::string, std::string> findings);
  /// Sets a free line of the diagnostics.
  void set(const std::string& key, const std::string& value);

  std::uint64_t inputs() const;
  std::uint64_t processed() const;
  std::uint64_t dropped(const std::string& reason) const;

  /// What became of the input, for somebody who finds no output: "150 inputs, none was usable (150
  /// dropped: stamp is 0)", "no input arrived".
  std::string describeInput(const std::string& input) const;

  /// ERROR, with the first cause, while everything is dropped: nothing was ever processed, or
  /// things are still dropped kPatience after the last one that was. Else WARN if something was
  /// dropped or a problem appeared since the report before, or what looks wrong; else OK.
  void fill(diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  static constexpr std::chrono::seconds kPatience{10};

  bool isAllDropped() const;
  void logLocked(const std::string& key, const std::string& problem);
  void fillDurations(diagnostic_updater::DiagnosticStatusWrapper& status) const;

  const std::string name_;
  mutable std::mutex mutex_;
  std::uint64_t inputs_ = 0;
  std::uint64_t processed_ = 0;
  std::uint64_t images_shared_ = 0;
  std::uint64_t images_copied_ = 0;
  const void* last_pixels_ = nullptr;
  std::map<std::string, std::uint64_t> dropped_;
  std::map<std::string, std::string> lines_;
  std::map<std::string, std::string> findings_;
  std::set<std::string> logged_findings_;
  LogThrottle throttle_;
  std::vector<double> durations_ms_;  ///< ring of the newest kMaxDurations
  std::string newest_problem_;
  std::uint64_t dropped_since_processed_ = 0;
  std::string first_problem_;  ///< of those
  std::chrono::steady_clock::time_point last_processed_;
  std::chrono::steady_clock::time_point last_dropped_;
};

/// Wall time since its construction.
class StageTimer {
 public:
  double elapsedMs() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_)
        .count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace tsg::ros_interface
