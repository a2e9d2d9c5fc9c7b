// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/end_report.h"

#include <ros/console.h>
#include <ros/init.h>

#include <algorithm>
#include <iostream>
#include <mutex>
#include <optional>

namespace tsg::ros_interface {
namespace {

struct Gathered {
  std::mutex mutex;
  std::optional<std::vector<EndReport>> reports;  ///< nothing: nobody gathers
};

/// Nodelets and the program that loads them know each other by name only, so what the ones say to
/// the other at their end lies here.
Gathered& gathered() {
  static Gathered instance;
  return instance;
}

void append(std::string& text, const std::string& more) {
  if (!more.empty()) text += (text.empty() ? "" : "; ") + more;
}

/// Files of all stages, by folder, in the order of the first stage that wrote there.
std::string describeFiles(const std::vector<EndReport>& reports) {
  std::vector<EndReport> folders;
  for (const auto& report : reports) {
    if (report.files.empty()) continue;
    const auto found = std::find_if(folders.begin(), folders.end(), [&](const EndReport& known) {
      return known.folder == report.folder;
    });
    if (found == folders.end()) {
      folders.push_back(report);
    } else {
      found->files.insert(found->files.end(), report.files.begin(), report.files.end());
    }
  }
  std::string text;
  for (const auto& folder : folders) append(text, describeWritten(folder.folder, folder.files));
  return text;
}

}  // namespace

std::string describeEnd(const std::vector<EndReport>& reports) {
  std::string text = describeFiles(reports);
  std::string reason;
  for (const auto& report : reports) {
    append(text, report.problem);
    if (report.isMissing() && reason.empty()) reason = report.reason;
  }
  const bool is_missing = std::any_of(reports.begin(), reports.end(),
                                      [](const EndReport& report) { return report.isMissing(); });
  if (!text.empty() || !is_missing) return text;
  return "no map was written" + (reason.empty() ? "" : ": " + reason);
}

void reportEnd(const EndReport& report) {
  const std::lock_guard<std::mutex> lock(gathered().mutex);
  if (gathered().reports) {
    gathered().reports->push_back(report);
    return;
  }
  const std::string line = describeEnd({report});
  if (line.empty()) return;
  if (!::ros::ok()) {
    // roscpp's console went with ros::shutdown(), which a manager calls before it drops its
    // nodelets.
    std::cerr << "[" << report.stage << "] " << line << std::endl;
  } else if (report.isMissing()) {
    ROS_ERROR_STREAM("[" << report.stage << "] " << line);
  } else {
    ROS_INFO_STREAM("[" << report.stage << "] " << line);
  }
}

EndGatherer::EndGatherer() {
  const std::lock_guard<std::mutex> lock(gathered().mutex);
  gathered().reports.emplace();
}

EndGatherer::~EndGatherer() {
  const std::lock_guard<std::mutex> lock(gathered().mutex);
  gathered().reports.reset();
}

std::vector<EndReport> EndGatherer::collect() {
  const std::lock_guard<std::mutex> lock(gathered().mutex);
  std::vector<EndReport> reports = std::move(*gathered().reports);
  gathered().reports.emplace();
  std::reverse(reports.begin(), reports.end());
  return reports;
}

}  // namespace tsg::ros_interface
