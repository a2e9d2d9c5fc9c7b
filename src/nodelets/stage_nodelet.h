// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <nodelet/nodelet.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "task_scene_graph/config/settings.h"
#include "task_scene_graph/ros/end_report.h"
#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/ros/parameters.h"
#include "task_scene_graph/ros/patience.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/state_publisher.h"

namespace tsg::nodelets {

/// What every stage's nodelet has: a start that names what is wrong, diagnostics, the services
/// `~flush`, `~pause`, `~resume` and `~reset`, the latched topic `~settings` with the parameters in
/// force, and a once-a-second look around. Services run in a thread of their own, so that one that
/// waits never holds up the topics, and topics in another.
///
/// Neither uses the nodelet's own queue: Debian 11's takes no callback before the nodelet has
/// started, while roscpp keeps the message, so that what comes meanwhile is never seen, or all
/// later messages are seen one too late.
///
/// A derived class calls `stopCallbacks()` first thing in its destructor.
class StageNodelet : public nodelet::Nodelet {
 protected:
  /// Reads parameters, subscribes, advertises. Whatever it throws is logged; the nodelet is then
  /// not loaded.
  virtual void start() = 0;
  /// About once a second of wall time, from the topics' thread.
  virtual void check() {}
  /// See Flush.srv; from the services' thread, as the two below.
  virtual msg::FlushResponse flush(const msg::FlushRequest& request,
                                   const ros_interface::Patience& patience) = 0;
  /// Forgets all that was built, as after a start. @returns what was forgotten, for a log.
  virtual std::string reset() = 0;
  /// Stops taking in images, or goes on. @returns a problem, or "".
  virtual std::string setPaused(bool is_paused);
  bool isPaused() const { return is_paused_; }

  /// Returns when the last callback has; none is called from then on.
  void stopCallbacks();
  ros_interface::StageReport& report() { return *report_; }
  /// Private node handle whose callbacks run in the services' thread.
  ros::NodeHandle& serviceHandle() { return service_handle_; }
  /// As getNodeHandle(), but callbacks run, once start() has returned, in the topics' thread.
  ros::NodeHandle& topicHandle() { return topic_handle_; }

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
  bool serveFlush(msg::FlushRequest& request, msg::FlushResponse& response);
  bool serveReset(std_srvs::TriggerRequest& request, std_srvs::TriggerResponse& response);
  bool servePaused(bool is_paused, std_srvs::TriggerResponse& response);
  void startServices();

  ros::CallbackQueue service_queue_;
  ros::NodeHandle service_handle_;
  ros::CallbackQueue topic_queue_;
  ros::NodeHandle topic_handle_;
  mutable std::mutex settings_mutex_;  ///< guards the two below
  config::StageSettings settings_;
  ros_interface::StatePublisher<msg::StageSettings> settings_publisher_;
  std::unique_ptr<ros_interface::StageReport> report_;
  std::unique_ptr<diagnostic_updater::Updater> diagnostics_;
  std::vector<ros::ServiceServer> servers_;
  std::atomic<bool> is_paused_{false};
  std::unique_ptr<ros::AsyncSpinner> service_spinner_;
  std::unique_ptr<ros::AsyncSpinner> topic_spinner_;
  ros::WallTimer timer_;
};

}  // namespace tsg::nodelets
