// SPDX-License-Identifier: BSD-3-Clause
#include "grasp_services.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <utility>

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/tracking/grasp_point.h"

namespace tsg::nodelets {
namespace {

constexpr double kMaxAge_s = 5.0;

std::string formatSeconds(double seconds) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f s", seconds);
  return text;
}

}  // namespace

GraspServices::GraspServices(const ros::NodeHandle& handle, std::string world_frame)
    : world_frame_(std::move(world_frame)), handle_(handle), spinner_(1, &queue_) {
  handle_.setCallbackQueue(&queue_);
  server_ = handle_.advertiseService("grasp_pixel", &GraspServices::serve, this);
  spinner_.start();
}

void GraspServices::noteFrame(Stamp stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  newest_stamp_ = stamp;
  newest_arrival_ = std::chrono::steady_clock::now();
}

void GraspServices::setView(View view) {
  const std::lock_guard<std::mutex> lock(mutex_);
  view_ = std::move(view);
}

void GraspServices::forget() {
  const std::lock_guard<std::mutex> lock(mutex_);
  view_.reset();
}

GraspServices::View GraspServices::newestView(double max_age_s, double& age_s) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!view_) {
    throw std::runtime_error(
        "nothing has been segmented yet: no image with a segmentation and a pose has come");
  }
  // By the camera's own clock as far as images tell it: it need not be the computer's.
  const std::chrono::duration<double> silence = std::chrono::steady_clock::now() - newest_arrival_;
  age_s = std::max(0.0, secondsBetween(view_->frame->stamp, newest_stamp_)) + silence.count();
  if (age_s <= max_age_s) return *view_;
  throw std::runtime_error("the newest segmented image is " + formatSeconds(age_s) +
                           " old, expected at most " + formatSeconds(max_age_s) +
                           ": the camera, the segmenter or the tracker stands still, or is paused");
}

void GraspServices::answer(const msg::GraspPixelRequest& request,
                           msg::GraspPixelResponse& response) const {
  if (!request.words.empty() || !request.image.data.empty()) {
    throw std::invalid_argument(
        "the tracker takes embeddings alone; the scene graph's service takes words and pictures");
  }
  const double max_age_s =
      request.max_age_s > 0.0F ? static_cast<double>(request.max_age_s) : kMaxAge_s;
  double age_s = 0.0;
  const View view = newestView(max_age_s, age_s);
  const Embedding question = Eigen::Map<const Embedding>(
      request.embedding.data(), static_cast<Eigen::Index>(request.embedding.size()));
  const auto grasp = tracking::findGraspPoint(*view.frame, *view.segmentation, question);
  response.score = static_cast<float>(grasp.score);
  response.margin = static_cast<float>(grasp.margin);
  response.header.stamp = ros_interface::toRosTime(view.frame->stamp);
  response.header.frame_id = world_frame_;
  response.point = ros_interface::toPoint(grasp.p_world);
  response.camera_frame = view.camera_frame;
  response.point_in_camera = ros_interface::toPoint(grasp.p_camera);
  response.u = static_cast<std::uint32_t>(grasp.u_px);
  response.v = static_cast<std::uint32_t>(grasp.v_px);
  response.segment = grasp.segment;
  response.segment_pixels = grasp.num_pixels;
  response.track = view.tracks.at(grasp.segment - 1U).value;
  response.age_s = static_cast<float>(age_s);
}

bool GraspServices::serve(msg::GraspPixelRequest& request, msg::GraspPixelResponse& response) {
  try {
    answer(request, response);
    response.success = 1;
  } catch (const std::exception& e) {
    response = msg::GraspPixelResponse();
    response.message = e.what();
  }
  return true;
}

}  // namespace tsg::nodelets
