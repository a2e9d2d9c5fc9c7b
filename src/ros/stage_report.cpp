// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/stage_report.h"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <ros/console.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "task_scene_graph/core/files.h"

namespace tsg::ros_interface {
namespace {

constexpr std::size_t kMaxDurations = 1000;

}  // namespace

void StageReport::countInput() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++inputs_;
}

void StageReport::countProcessed(double duration_ms) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (durations_ms_.size() < kMaxDurations) {
    durations_ms_.push_back(duration_ms);
  } else {
    durations_ms_[processed_ % kMaxDurations] = duration_ms;
  }
  ++processed_;
  dropped_since_processed_ = 0;
  last_processed_ = std::chrono::steady_clock::now();
}

void StageReport::countDropped(const std::string& reason, const std::string& problem,
                               std::uint64_t count) {
  if (count == 0) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  dropped_[reason] += count;
  newest_problem_ = problem.empty() ? reason : problem;
  if (dropped_since_processed_ == 0) first_problem_ = newest_problem_;
  dropped_since_processed_ += count;
  last_dropped_ = std::chrono::steady_clock::now();
  if (!problem.empty()) logLocked(reason, problem);
}

void StageReport::countImage(bool is_shared, const void* pixels) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++(is_shared ? images_shared_ : images_copied_);
  last_pixels_ = pixels;
}

void StageReport::warn(const std::string& key, const std::string& problem) {
  const std::lock_guard<std::mutex> lock(mutex_);
  newest_problem_ = problem;
  logLocked(key, problem);
}

void StageReport::set(const std::string& key, const std::string& value) {
  const std::lock_guard<std::mutex> lock(mutex_);
  lines_[key] = value;
}

void StageReport::setFindings(std::map<std::string, std::string> findings) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& [key, text] : findings) {
    if (logged_findings_.insert(key).second) {
      ROS_WARN_STREAM("[" << name_ << "] plausibility: " << text);
    }
  }
  findings_ = std::move(findings);
}

std::uint64_t StageReport::inputs() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return inputs_;
}

std::uint64_t StageReport::processed() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return processed_;
}

std::uint64_t StageReport::dropped(const std::string& reason) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = dropped_.find(reason);
  return found == dropped_.end() ? 0 : found->second;
}

std::string StageReport::describeInput(const std::string& input) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<std::pair<std::uint64_t, std::string>> drops;
  for (const auto& [reason, count] : dropped_) drops.emplace_back(count, reason);
  if (inputs_ == 0 && drops.empty()) return "no " + input + " arrived";
  std::sort(drops.rbegin(), drops.rend());  // the most frequent reason first
  std::string text;
  for (const auto& [count, reason] : drops) {
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " dropped: " + reason;
  }
  const std::string all = formatCount(inputs_, input);
  const std::string used = processed_ == 0 ? "none" : std::to_string(processed_);
  return all + " arrived, " + used + " was usable" + (text.empty() ? "" : " (" + text + ")");
}

void StageReport::fill(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (isAllDropped()) {
    status.summary(diagnostic_msgs::DiagnosticStatus::ERROR,
                   "nothing is usable, " + std::to_string(dropped_since_processed_) +
                       " dropped, first: " + first_problem_);
  } else if (newest_problem_.empty() && !findings_.empty()) {
    status.summary(diagnostic_msgs::DiagnosticStatus::WARN, findings_.begin()->second);
  } else if (newest_problem_.empty()) {
    status.summary(diagnostic_msgs::DiagnosticStatus::OK,
                   inputs_ == 0 ? "no input yet" : "running");
  } else {
    status.summary(diagnostic_msgs::DiagnosticStatus::WARN, newest_problem_);
  }
  newest_problem_.clear();
  status.add("inputs", inputs_);
  status.add("processed", processed_);
  for (const auto& [reason, count] : dropped_) status.add("dropped: " + reason, count);
  status.add("images shared", images_shared_);
  status.add("images copied", images_copied_);
  status.addf("pixels of the last image", "%p", last_pixels_);
  fillDurations(status);
  for (const auto& [key, text] : findings_) status.add("plausibility: " + key, text);
  for (const auto& [key, value] : lines_) status.add(key, value);
}

bool StageReport::isAllDropped() const {
  if (dropped_since_processed_ == 0) return false;
  return processed_ == 0 || last_dropped_ - last_processed_ > kPatience;
}

void StageReport::fillDurations(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  if (durations_ms_.empty()) return;
  std::vector<double> sorted = durations_ms_;
  std::sort(sorted.begin(), sorted.end());
  const double sum = std::accumulate(sorted.begin(), sorted.end(), 0.0);
  status.addf("ms mean", "%.2f", sum / static_cast<double>(sorted.size()));
  status.addf("ms p95", "%.2f", sorted[(sorted.size() - 1) * 95 / 100]);
  status.addf("ms max", "%.2f", sorted.back());
}

void StageReport::logLocked(const std::string& key, const std::string& problem) {
  const auto unsaid = throttle_.admit(key, problem, std::chrono::steady_clock::now());
  if (!unsaid) return;
  const std::string more = *unsaid == 0 ? "" : " (and " + std::to_string(*unsaid) + " more)";
  ROS_WARN_STREAM("[" << name_ << "] " << problem << more);
}

}  // namespace tsg::ros_interface
