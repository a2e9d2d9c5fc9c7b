// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/run_nodelets.h"

#include <nodelet/loader.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <algorithm>
#include <csignal>

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::ros_interface {
namespace {

volatile std::sig_atomic_t is_asked_to_stop = 0;

void handleSignal(int) { is_asked_to_stop = 1; }

std::vector<std::string> resolveNames(const std::vector<NodeletSpec>& nodelets) {
  std::vector<std::string> names;
  for (const auto& nodelet : nodelets) {
    names.push_back(nodelet.name.empty() ? ::ros::this_node::getName()
                                         : ::ros::names::resolve(nodelet.name));
  }
  return names;
}

bool loadAll(nodelet::Loader& loader, const std::vector<NodeletSpec>& nodelets,
             const std::vector<std::string>& names, const std::vector<std::string>& arguments) {
  for (std::size_t i = 0; i < nodelets.size(); ++i) {
    if (loader.load(names[i], nodelets[i].type, ::ros::names::getRemappings(), arguments)) continue;
    ROS_FATAL_STREAM(names[i] << " (" << nodelets[i].type << ") did not load; see above for why");
    return false;
  }
  return true;
}

void spinUntilStopped() {
  while (::ros::ok() && is_asked_to_stop == 0) {
    ::ros::getGlobalCallbackQueue()->callAvailable(::ros::WallDuration(0.05));
  }
}

}  // namespace

FinishedStages finishStages(const std::vector<std::string>& stages) {
  FinishedStages result;
  msg::Finish call;
  for (const auto& stage : stages) {
    const std::string service = ::ros::names::append(stage, "finish");
    if (!::ros::service::exists(service, false)) continue;
    if (!::ros::service::call(service, call)) {
      result.problems.push_back(service + " failed");
    } else if (!call.response.success) {
      result.problems.push_back(service + ": " + call.response.message);
    }
    call.request.last_id = call.response.last_id;
    call.request.stamp = call.response.stamp;
  }
  result.last_id = call.request.last_id;
  result.stamp = toStamp(call.request.stamp);
  return result;
}

int runNodelets(int argc, char** argv, const std::string& node_name,
                const std::vector<NodeletSpec>& nodelets) {
  ::ros::init(argc, argv, node_name, ::ros::init_options::NoSigintHandler);
  std::signal(SIGINT, handleSignal);
  std::signal(SIGTERM, handleSignal);
  std::vector<std::string> names = resolveNames(nodelets);
  nodelet::Loader loader;
  if (!loadAll(loader, nodelets, names, {argv + 1, argv + argc})) {
    ::ros::shutdown();
    return 1;
  }
  spinUntilStopped();
  if (::ros::ok()) {
    for (const auto& problem : finishStages(names).problems) {
      ROS_WARN_STREAM("at the end: " << problem);
    }
  }
  std::reverse(names.begin(), names.end());
  for (const auto& name : names) loader.unload(name);
  ::ros::shutdown();
  return 0;
}

}  // namespace tsg::ros_interface
