// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <nodelet/nodelet.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>

#include <chrono>
#include <memory>
#include <string>

#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/ros/parameters.h"
#include "task_scene_graph/ros/stage_report.h"

namespace tsg::nodelets {

using Deadline = std::chrono::steady_clock::time_point;

/// What every stage's nodelet has: a start that names what is wrong, diagnostics, the service
/// `~finish`, and a once-a-second look around. Services run in a thread of their own, so that one
/// that waits never holds up the manager's threads.
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

  /// Private parameters as a checked configuration.
  template <typename Config>
  Config loadConfig() {
    return ros_interface::loadParameters<Config>(getPrivateNodeHandle());
  }

 private:
  void onInit() final;
  void look();
  bool serveFinish(msg::FinishRequest& request, msg::FinishResponse& response);

  std::unique_ptr<ros_interface::StageReport> report_;
  std::unique_ptr<diagnostic_updater::Updater> diagnostics_;
  ros::CallbackQueue service_queue_;
  ros::NodeHandle service_handle_;
  ros::ServiceServer finish_server_;
  std::unique_ptr<ros::AsyncSpinner> service_spinner_;
  ros::WallTimer timer_;
};

/// Parameters that every stage has besides its own.
struct CommonConfig {
  double diagnostic_period = 1.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("diagnostic_period", self.diagnostic_period, {0.05, 60.0}, "s",
            "wall time between two messages on /diagnostics");
  }
};

}  // namespace tsg::nodelets
