// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <ros/ros.h>
#include <ros/topic.h>
#include <task_scene_graph/PlanPath.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "task_scene_graph/ros/messages.h"

namespace tsg {

/// The scene graph could not do what was asked; the map is as it was.
class SceneGraphError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The scene graph for robot programs, in a few lines; the header alone, with roscpp, is enough:
///
///     ros::init(argc, argv, "fetch");
///     tsg::SceneGraphClient scene;
///     if (const auto mug = scene.find("coffee mug")) scene.goTo(*mug);
///
/// Every call throws SceneGraphError, which says what is wrong, where the graph refuses or nobody
/// serves it within the time. All coordinates are in the frame of the map, metres. The same in
/// Python: task_scene_graph_client. Thread-safe but for goTo().
class SceneGraphClient {
 public:
  /// @param stage      name of the scene graph stage, as in launch files
  /// @param timeout_s  wall time that a service or a subscriber is waited for
  explicit SceneGraphClient(std::string stage = "/task_scene_graph/scene_graph",
                            double timeout_s = 10.0)
      : stage_(std::move(stage)), timeout_s_(timeout_s) {}
  SceneGraphClient(const SceneGraphClient&) = delete;
  SceneGraphClient& operator=(const SceneGraphClient&) = delete;
  /// A program that ends takes with it what its listeners have not read, as ROS confirms no
  /// message: waits until two seconds have passed since the last goal.
  ~SceneGraphClient() {
    constexpr std::chrono::seconds kGrace(2);
    if (goal_sent_ && ros::ok()) std::this_thread::sleep_until(*goal_sent_ + kGrace);
  }

  /// All answers to a question (words, an embedding or an image), each kind by score.
  msg::AskResponse ask(const msg::AskRequest& request) const {
    return call<msg::Ask>(stage_ + "/ask", request);
  }
  msg::AskResponse ask(const std::string& words, std::uint32_t max_answers = 5) const {
    msg::AskRequest request;
    request.words = words;
    request.max_answers = max_answers;
    return ask(request);
  }

  /// The object or, where that fits better, the primitive meant; none if nothing reaches alpha.
  std::optional<msg::Answer> find(const std::string& words) const {
    return chooseThing(ask(words, 1));
  }
  /// The region that fits best; none if there are no regions.
  std::optional<msg::Answer> findRegion(const std::string& words) const {
    const auto regions = ask(words, 1).regions;
    return regions.empty() ? std::nullopt : std::optional<msg::Answer>(regions.front());
  }

  /// Where to reach for what the camera sees now: a pixel and its point in the map; none if no
  /// segment reaches alpha.
  std::optional<msg::GraspPixelResponse> graspPixel(const std::string& words) const {
    msg::GraspPixelRequest request;
    request.words = words;
    auto response = call<msg::GraspPixel>(stage_ + "/grasp_pixel", request);
    if (response.is_found == 0) return std::nullopt;
    return response;
  }

  /// A path for the robot, from where the camera is unless `request` says otherwise.
  msg::PlanPathResponse planPath(const msg::PlanPathRequest& request) const {
    return call<msg::PlanPath>(chainNamespace() + "/plan_path", request);
  }
  /// ... to the thing or region that words mean: of those that reach alpha the one of the highest
  /// score.
  msg::PlanPathResponse pathTo(const std::string& words) const {
    return planPath(makeRequest(ask(words, 1), words));
  }
  /// ... to an answer: before a thing's box, or to a place or region.
  msg::PlanPathResponse pathTo(const msg::Answer& answer) const {
    return planPath(makeRequest(answer));
  }
  /// ... to a point at or above the floor.
  msg::PlanPathResponse pathTo(const geometry_msgs::Point& point) const {
    msg::PlanPathRequest request;
    request.goal_kind = msg::PlanPathRequest::POINT;
    request.point = point;
    return planPath(request);
  }
  /// ... to an object or a region by id (PlanPathRequest::OBJECT, REGION, PLACE).
  msg::PlanPathResponse pathTo(std::uint8_t kind, std::uint64_t id) const {
    msg::PlanPathRequest request;
    request.goal_kind = kind;
    request.id = id;
    return planPath(request);
  }

  /// Plans as pathTo() and sends the path's last pose to whoever drives the robot: move_base takes
  /// goals on `/move_base_simple/goal`. Returns the path.
  template <typename Goal>
  msg::PlanPathResponse goTo(const Goal& goal,
                             const std::string& topic = "/move_base_simple/goal") {
    msg::PlanPathResponse response = pathTo(goal);
    if (response.path.poses.empty()) throw SceneGraphError("go_to: the robot is there already");
    sendGoal(response.path.poses.back().pose, response.path.header.frame_id, topic);
    return response;
  }

  /// Why things are clustered as they are, in words. @param what  msg::ExplainRequest::OBJECT, ...
  std::string explain(std::uint8_t what, std::uint64_t a, std::uint64_t b = 0) const {
    msg::ExplainRequest request;
    request.what = what;
    request.a = a;
    request.b = b;
    return call<msg::Explain>(stage_ + "/explain", request).message;
  }

  /// The tasks in force.
  msg::TasksInForce tasks() const {
    const auto message =
        ros::topic::waitForMessage<msg::TasksInForce>(stage_ + "/tasks", ros::Duration(timeout_s_));
    if (message == nullptr) throw SceneGraphError("nobody publishes " + stage_ + "/tasks");
    return *message;
  }
  /// Sets, adds, removes or renames tasks; returns those in force.
  msg::TasksInForce changeTasks(const msg::ChangeTasksRequest& request) const {
    return call<msg::ChangeTasks>(stage_ + "/change_tasks", request).in_force;
  }
  msg::TasksInForce addTasks(const std::vector<std::string>& names) const {
    return changeTasks(makeChange(msg::ChangeTasksRequest::ADD, names));
  }
  msg::TasksInForce removeTasks(const std::vector<std::string>& names) const {
    return changeTasks(makeChange(msg::ChangeTasksRequest::REMOVE, names));
  }
  msg::TasksInForce setTasks(const std::vector<std::string>& names) const {
    return changeTasks(makeChange(msg::ChangeTasksRequest::SET, names));
  }

 private:
  template <typename Service>
  typename Service::Response call(const std::string& name,
                                  const typename Service::Request& request) const {
    Service exchange;
    exchange.request = request;
    const auto timeout = ros::Duration(timeout_s_);
    if (!ros::service::waitForService(name, timeout)) {
      throw SceneGraphError("nobody serves " + name + " (waited " + std::to_string(timeout_s_) +
                            " s): does the chain run, and is the name of its stage right?");
    }
    if (!ros::service::call(name, exchange)) {
      throw SceneGraphError("the call of " + name + " failed: the chain may have ended meanwhile");
    }
    if (exchange.response.success == 0) throw SceneGraphError(exchange.response.message);
    return exchange.response;
  }

  static std::optional<msg::Answer> chooseThing(const msg::AskResponse& answers) {
    std::optional<msg::Answer> best;
    for (const auto* kind : {&answers.objects, &answers.primitives}) {
      if (kind->empty() || kind->front().score < answers.alpha) continue;
      if (!best || kind->front().score > best->score) best = kind->front();
    }
    return best;
  }

  static msg::PlanPathRequest makeRequest(const msg::Answer& answer) {
    msg::PlanPathRequest request;
    const auto& size = answer.size;
    const bool has_box = std::max({size.x, size.y, size.z}) > 0.0;
    request.goal_kind = has_box ? msg::PlanPathRequest::BOX : msg::PlanPathRequest::POINT;
    request.box.pose = answer.pose;
    request.box.size = size;
    request.point = answer.pose.position;
    return request;
  }

  static msg::PlanPathRequest makeRequest(const msg::AskResponse& answers,
                                          const std::string& words) {
    std::optional<msg::Answer> best = chooseThing(answers);
    if (!answers.regions.empty() && answers.regions.front().score >= answers.place_alpha &&
        (!best || answers.regions.front().score > best->score)) {
      best = answers.regions.front();
    }
    if (!best) throw SceneGraphError("no path to '" + words + "': " + answers.message);
    return makeRequest(*best);
  }

  static msg::ChangeTasksRequest makeChange(std::uint8_t action,
                                            const std::vector<std::string>& names) {
    msg::ChangeTasksRequest request;
    request.action = action;
    for (const auto& name : names) {
      request.tasks.emplace_back();
      request.tasks.back().name = name;
    }
    return request;
  }

  /// The namespace that the chain's stages are in: "" for a stage at the root.
  std::string chainNamespace() const { return stage_.substr(0, stage_.rfind('/')); }

  void sendGoal(const geometry_msgs::Pose& pose, const std::string& frame,
                const std::string& topic) {
    if (goals_.getTopic() != topic) {
      goals_ = handle_.advertise<geometry_msgs::PoseStamped>(topic, 1);
    }
    const auto deadline =
        std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s_);
    while (goals_.getNumSubscribers() == 0) {
      if (std::chrono::steady_clock::now() > deadline) {
        throw SceneGraphError("nobody takes goals on " + topic + ": is move_base running?");
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    geometry_msgs::PoseStamped goal;
    goal.pose = pose;
    goal.header.frame_id = frame;
    goal.header.stamp = ros::Time::now();
    goals_.publish(goal);
    goal_sent_ = std::chrono::steady_clock::now();
  }

  std::string stage_;
  double timeout_s_;
  ros::NodeHandle handle_;  ///< starts the node, if that is not done yet
  ros::Publisher goals_;
  std::optional<std::chrono::steady_clock::time_point> goal_sent_;
};

}  // namespace tsg
