// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <nodelet/nodelet.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <string>

#include "task_scene_graph/config/settings.h"
#include "task_scene_graph/ros/end_report.h"
#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/ros/parameters.h"
#include "task_scene_graph/ros/stage_report.h"

namespace tsg::nodelets {

using Deadline = std::chrono::steady_clock::time_point;

/// What every stage's nodelet has: a start that names what is wrong, diagnostics, the service
/// `~finish`, the latched topic `~settings` with the parameters in force, and a once-a-second look
/// around. Services run in a thread of their own, so that one that waits never holds up the
/// manager's threads.
///
/// A derived class calls `stopServices()` first thing in its destructor.
class StageNodelet : public nodelet::Nodelet {
 protected:
  /// Reads parameters, subscribes, advertises. Whatever it throws is logged; the nodelet is then
  /// not loaded.
  virtual void start() = 0;
  /// About once a second of wall time, from the subscribers' queue.
  virtual void check() {}
  /// See Finish.srv.
  virtual msg::FinishResponse finish(const msg::FinishRequest& request, Deadline deadline) = 0;

  void stopServices();
  ros_interface::StageReport& report() { return *report_; }
  /// Private node handle whose callbacks run in the services' thread.
  ros::NodeHandle& serviceHandle() { return service_handle_; }

  /// The parameters out of all their sources (ros/parameters.h) as a checked configuration.
  /// @param suggest  what the model set suggests, if it suggests anything to this stage
  template <typename Config>
  Config loadConfig(const ros_interface::Suggest<Config>& suggest = nullptr) {
    const auto loaded = ros_interface::loadParameters(getPrivateNodeHandle(), suggest);
    setSettings({Config::kStage, config::listSettings(loaded.config, loaded.origins)});
    return loaded.config;
  }
  /// Says what holds, also to `~settings` once the stage has started.
  void setSettings(config::StageSettings settings);
  config::StageSettings settings() const;

 private:
  void onInit() final;
  void publishSettings();
  void look();
  bool serveFinish(msg::FinishRequest& request, msg::FinishResponse& response);

  mutable std::mutex settings_mutex_;  ///< guards the two below
  config::StageSettings settings_;
  ros::Publisher settings_publisher_;
  std::unique_ptr<ros_interface::StageReport> report_;
  std::unique_ptr<diagnostic_updater::Updater> diagnostics_;
  ros::CallbackQueue service_queue_;
  ros::NodeHandle service_handle_;
  ros::ServiceServer finish_server_;
  std::unique_ptr<ros::AsyncSpinner> service_spinner_;
  ros::WallTimer timer_;
};

}  // namespace tsg::nodelets
