// SPDX-License-Identifier: BSD-3-Clause
#include "navigation_stage.h"

#include <nav_msgs/Path.h>

#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/planning/goals.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/scene_graph_conversions.h"

namespace tsg::nodelets {
namespace {

std::uint8_t toMessage(planning::Blockage::Kind kind) {
  switch (kind) {
    case planning::Blockage::Kind::kObstacle:
      return msg::PlanPathResponse::OBSTACLE;
    case planning::Blockage::Kind::kNarrow:
      return msg::PlanPathResponse::NARROW;
    case planning::Blockage::Kind::kUnknown:
      break;
  }
  return msg::PlanPathResponse::UNKNOWN;
}

nav_msgs::Path toMessage(const planning::Path& path, const std_msgs::Header& header) {
  nav_msgs::Path message;
  message.header = header;
  for (const planning::PathPoint& point : path.points) {
    geometry_msgs::PoseStamped pose;
    pose.header = header;
    pose.pose.position = ros_interface::toPoint(point.position_m);
    pose.pose.orientation.z = std::sin(point.yaw_rad / 2.0);
    pose.pose.orientation.w = std::cos(point.yaw_rad / 2.0);
    message.poses.push_back(pose);
  }
  return message;
}

planning::Goal toBoxGoal(const msg::BoundingBox& box) {
  const OrientedBox oriented = ros_interface::toOrientedBox(box);
  const Eigen::Vector3d& size_m = oriented.size_m;
  const bool has_size = size_m.minCoeff() >= 0.0 && size_m.maxCoeff() > 0.0 && size_m.allFinite();
  if (has_size && oriented.center_m.allFinite()) return {oriented.center_m, oriented};
  throw std::invalid_argument(
      "box of " + std::to_string(size_m.x()) + " x " + std::to_string(size_m.y()) + " x " +
      std::to_string(size_m.z()) +
      " m: expected the size of a thing, none of it negative, and a centre of finite numbers");
}

void fillResponse(const planning::PlanResult& result, const std_msgs::Header& header,
                  msg::PlanPathResponse& response) {
  response.success = result.isFound() ? 1 : 0;
  response.message = result.message;
  response.path = toMessage(result.path, header);
  response.length_m = result.path.length_m;
  response.least_clearance_m = result.path.least_clearance_m;
  response.narrowest = ros_interface::toPoint(result.path.narrowest_m);
  for (const PlaceId place : result.path.places) response.places.push_back(place.value);
  response.has_view = result.path.has_view ? 1 : 0;
  if (!result.blockage) return;
  response.blocked_by = toMessage(result.blockage->kind);
  response.blocked_at = ros_interface::toPoint(result.blockage->position_m);
  response.last_place = result.blockage->last_place.value;
}

}  // namespace

NavigationStage::NavigationStage(const ros::NodeHandle& handle, const Options& options,
                                 ros_interface::StageReport& report)
    : options_((config::validate(options.planner, "planner"), options)),
      late_(report),
      storeys_(handle, late_, options.world_frame),
      handle_(handle),
      spinner_(1, &queue_) {
  handle_.setCallbackQueue(&queue_);
  path_publisher_ = {handle_, "path"};
  graph_subscriber_ = handle_.subscribe("scene_graph", 1, &NavigationStage::onSceneGraph, this);
  server_ = handle_.advertiseService("plan_path", &NavigationStage::servePlan, this);
  spinner_.start();
}

void NavigationStage::setCamera(const Eigen::Vector3d& position_m) {
  const std::lock_guard<std::mutex> lock(mutex_);
  camera_m_ = position_m;
}

void NavigationStage::forgetCamera() {
  const std::lock_guard<std::mutex> lock(mutex_);
  camera_m_.reset();
}

void NavigationStage::setMap(const PlaceGraph& places, const places::GroundPlan& plan) {
  Map map;
  map.places.stamp = places.stamp;
  map.places.edges = places.edges;
  for (const Place& place : places.places) {
    map.places.places.push_back({place.id, place.position_m, place.clearance_m, {}, 0});
  }
  map.plan = plan;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::swap(map_, map);
    ++num_maps_;
  }
  storeys_.update(plan, places.stamp);
}

void NavigationStage::stop() {
  server_.shutdown();
  graph_subscriber_.shutdown();
  spinner_.stop();
  late_.stop();
}

void NavigationStage::onSceneGraph(const msg::SceneGraphConstPtr& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  graph_ = message;
}

bool NavigationStage::servePlan(Request& request, Response& response) {
  try {
    plan(request, response);
  } catch (const std::exception& e) {
    response.success = 0;
    response.message = e.what();
  }
  // Whoever looks at the topic does not see a path of before.
  if (response.success == 0) response.path.header.frame_id = options_.world_frame;
  path_publisher_.publish(response.path);
  return true;
}

void NavigationStage::plan(const Request& request, Response& response) {
  planning::PlanRequest plan_request;
  plan_request.start_m = findStart(request);
  plan_request.goal = findGoal(request, response);
  plan_request.robot_radius_m =
      request.robot_radius_m == 0.0 ? options_.planner.robot_radius_m : request.robot_radius_m;
  std_msgs::Header header;
  header.frame_id = options_.world_frame;
  const auto used = planner();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    header.stamp = ros_interface::toRosTime(map_.places.stamp);
  }
  fillResponse(used->plan(plan_request), header, response);
}

std::shared_ptr<const planning::Planner> NavigationStage::planner() {
  Map map;
  std::uint64_t num_maps = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (map_.planner != nullptr) return map_.planner;
    map = map_;
    num_maps = num_maps_;
  }
  auto made = std::make_shared<planning::Planner>(map.places, map.plan, options_.planner);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (num_maps_ == num_maps) map_.planner = made;
  return made;
}

Eigen::Vector3d NavigationStage::findStart(const Request& request) const {
  if (request.has_start != 0) return ros_interface::toVector(request.start);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (camera_m_) return *camera_m_;
  throw std::runtime_error("no image with a pose has come yet: set has_start and start");
}

planning::Goal NavigationStage::findGoal(const Request& request, Response& response) const {
  response.goal_id = request.id;
  std::unique_lock<std::mutex> lock(mutex_);
  if (request.goal_kind == Request::POINT) return {ros_interface::toVector(request.point), {}};
  if (request.goal_kind == Request::PLACE) {
    return planning::findPlaceGoal(map_.places, PlaceId{request.id});
  }
  if (request.goal_kind == Request::BOX) return toBoxGoal(request.box);
  if (request.goal_kind > Request::BOX) {
    throw std::invalid_argument(
        "goal_kind is " + std::to_string(request.goal_kind) +
        ", expected 0 (point), 1 (place), 2 (object), 3 (region) or 4 (box)");
  }
  if (graph_ == nullptr) {
    throw std::runtime_error("nothing has come on " + graph_subscriber_.getTopic() +
                             " yet: objects and regions are not known");
  }
  const msg::SceneGraphConstPtr message = graph_;
  lock.unlock();
  const scene_graph::SceneGraph graph = ros_interface::fromMessage(*message);
  if (request.goal_kind == Request::OBJECT) {
    if (request.id == 0) response.goal_id = planning::findObject(graph, request.name).value;
    return planning::findObjectGoal(graph, ObjectId{response.goal_id});
  }
  if (request.id == 0) response.goal_id = planning::findRegion(graph, request.name).value;
  return planning::findRegionGoal(graph, RegionId{response.goal_id});
}

}  // namespace tsg::nodelets
