// SPDX-License-Identifier: BSD-3-Clause
#include "stage_nodelet.h"

#include <ros/network.h>

#include <map>
#include <utility>

#include "task_scene_graph/ros/flush.h"
#include "task_scene_graph/ros/settings_conversions.h"

namespace tsg::nodelets {
namespace {

constexpr double kFlushTimeout_s = 60.0;
constexpr double kFlushQuiet_s = 10.0;

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
    topic_handle_ = ros::NodeHandle(getNodeHandle());
    topic_handle_.setCallbackQueue(&topic_queue_);
    start();
    publishSettings();
    const double period_s = getPrivateNodeHandle().param("diagnostic_period", 1.0);
    diagnostics_ = std::make_unique<diagnostic_updater::Updater>(getNodeHandle(),
                                                                 getPrivateNodeHandle(), getName());
    diagnostics_->setHardwareID(ros::network::getHost());
    diagnostics_->add("stage", [this](auto& status) { report_->fill(status); });
    timer_ = topic_handle_.createWallTimer(ros::WallDuration(period_s),
                                           [this](const ros::WallTimerEvent&) { look(); });
    topic_spinner_ = std::make_unique<ros::AsyncSpinner>(1, &topic_queue_);
    topic_spinner_->start();
    startServices();
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
  ros::NodeHandle handle(getPrivateNodeHandle());
  handle.setCallbackQueue(&topic_queue_);
  settings_publisher_ = {handle, "settings"};
  settings_publisher_.publish(ros_interface::toMessage(settings_));
  NODELET_INFO_STREAM("[" << getName() << "] parameters: " << countOrigins(settings_.settings));
}

void StageNodelet::look() {
  check();
  diagnostics_->force_update();
}

void StageNodelet::startServices() {
  using Request = std_srvs::TriggerRequest;
  using Response = std_srvs::TriggerResponse;
  const boost::function<bool(Request&, Response&)> pause = [this](Request&, Response& response) {
    return servePaused(true, response);
  };
  const boost::function<bool(Request&, Response&)> resume = [this](Request&, Response& response) {
    return servePaused(false, response);
  };
  servers_.push_back(service_handle_.advertiseService("flush", &StageNodelet::serveFlush, this));
  servers_.push_back(service_handle_.advertiseService("reset", &StageNodelet::serveReset, this));
  servers_.push_back(service_handle_.advertiseService("pause", pause));
  servers_.push_back(service_handle_.advertiseService("resume", resume));
  service_spinner_ = std::make_unique<ros::AsyncSpinner>(1, &service_queue_);
  service_spinner_->start();
}

bool StageNodelet::serveFlush(msg::FlushRequest& request, msg::FlushResponse& response) {
  const double timeout_s = request.timeout_s > 0.0F ? request.timeout_s : kFlushTimeout_s;
  const double quiet_s = request.quiet_s > 0.0F ? request.quiet_s : kFlushQuiet_s;
  const ros_interface::FlushGuard guard;
  response = flush(request, ros_interface::Patience::from(timeout_s, quiet_s));
  response.success = response.missing.empty() ? 1 : 0;
  return true;
}

bool StageNodelet::serveReset(std_srvs::TriggerRequest&, std_srvs::TriggerResponse& response) {
  try {
    response.message = reset();
    response.success = 1;
    NODELET_INFO_STREAM("[" << getName() << "] reset: " << response.message);
  } catch (const std::exception& e) {
    response.message = e.what();
    NODELET_ERROR_STREAM("[" << getName() << "] reset: " << response.message);
  }
  return true;
}

bool StageNodelet::servePaused(bool is_paused, std_srvs::TriggerResponse& response) {
  response.message = setPaused(is_paused);
  response.success = response.message.empty() ? 1 : 0;
  NODELET_INFO_STREAM("[" << getName() << "] " << (is_paused ? "paused" : "goes on") << " "
                          << response.message);
  return true;
}

std::string StageNodelet::setPaused(bool is_paused) {
  is_paused_ = is_paused;
  report().set("paused", is_paused ? "yes" : "no");
  return "";
}

void StageNodelet::stopCallbacks() {
  timer_.stop();
  if (service_spinner_ != nullptr) service_spinner_->stop();
  if (topic_spinner_ != nullptr) topic_spinner_->stop();
  for (auto& server : servers_) server.shutdown();
}

}  // namespace tsg::nodelets
