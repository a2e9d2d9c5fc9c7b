// SPDX-License-Identifier: BSD-3-Clause
#include "stage_nodelet.h"

#include <map>

#include "task_scene_graph/ros/settings_conversions.h"

namespace tsg::nodelets {
namespace {

constexpr double kFinishTimeout_s = 10.0;

/// "12 from file '/home/u/my.yaml', 1 from parameter server, 60 from default".
std::string countOrigins(const std::vector<config::Setting>& settings) {
  std::map<std::string, std::size_t> counts;
  for (const auto& setting : settings) ++counts[setting.origin];
  std::string text;
  for (const auto& [origin, count] : counts) {
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " from " + origin;
  }
  return text;
}

}  // namespace

void StageNodelet::onInit() {
  try {
    report_ = std::make_unique<ros_interface::StageReport>(getName());
    service_handle_ = ros::NodeHandle(getPrivateNodeHandle());
    service_handle_.setCallbackQueue(&service_queue_);
    start();
    publishSettings();
    const double period_s = getPrivateNodeHandle().param("diagnostic_period", 1.0);
    diagnostics_ = std::make_unique<diagnostic_updater::Updater>(getNodeHandle(),
                                                                 getPrivateNodeHandle(), getName());
    diagnostics_->setHardwareID("none");
    diagnostics_->add("stage", [this](auto& status) { report_->fill(status); });
    timer_ = getNodeHandle().createWallTimer(ros::WallDuration(period_s),
                                             [this](const ros::WallTimerEvent&) { look(); });
    finish_server_ = service_handle_.advertiseService("finish", &StageNodelet::serveFinish, this);
    service_spinner_ = std::make_unique<ros::AsyncSpinner>(1, &service_queue_);
    service_spinner_->start();
  } catch (const std::exception& e) {
    NODELET_FATAL_STREAM("[" << getName() << "] not started: " << e.what());
    throw;
  }
}

void StageNodelet::setSettings(config::StageSettings settings) {
  const std::lock_guard<std::mutex> lock(settings_mutex_);
  settings_ = std::move(settings);
  if (settings_publisher_) settings_publisher_.publish(ros_interface::toMessage(settings_));
}

config::StageSettings StageNodelet::settings() const {
  const std::lock_guard<std::mutex> lock(settings_mutex_);
  return settings_;
}

void StageNodelet::publishSettings() {
  const std::lock_guard<std::mutex> lock(settings_mutex_);
  settings_publisher_ = getPrivateNodeHandle().advertise<msg::StageSettings>("settings", 1, true);
  settings_publisher_.publish(ros_interface::toMessage(settings_));
  NODELET_INFO_STREAM("[" << getName() << "] parameters: " << countOrigins(settings_.settings));
}

void StageNodelet::look() {
  check();
  diagnostics_->force_update();
}

bool StageNodelet::serveFinish(msg::FinishRequest& request, msg::FinishResponse& response) {
  const double timeout_s = request.timeout_s > 0.0F ? request.timeout_s : kFinishTimeout_s;
  const auto timeout = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(timeout_s));
  response = finish(request, std::chrono::steady_clock::now() + timeout);
  return true;
}

void StageNodelet::stopServices() {
  timer_.stop();
  if (service_spinner_ != nullptr) service_spinner_->stop();
  finish_server_.shutdown();
}

}  // namespace tsg::nodelets
