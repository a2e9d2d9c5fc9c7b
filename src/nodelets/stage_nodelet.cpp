// SPDX-License-Identifier: BSD-3-Clause
#include "stage_nodelet.h"

namespace tsg::nodelets {
namespace {

constexpr double kFinishTimeout_s = 10.0;

}  // namespace

void StageNodelet::onInit() {
  try {
    report_ = std::make_unique<ros_interface::StageReport>(getName());
    service_handle_ = ros::NodeHandle(getPrivateNodeHandle());
    service_handle_.setCallbackQueue(&service_queue_);
    start();
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
