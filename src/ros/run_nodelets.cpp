// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/run_nodelets.h"

#include <nodelet/loader.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <iostream>
#include <thread>

#include "task_scene_graph/ros/end_report.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::ros_interface {
namespace {

volatile std::sig_atomic_t signal_received = 0;

void noteSignal(int signal) { signal_received = signal; }

/// Before the stages run there is nothing to finish: roscpp gives up waiting for the master, and a
/// second signal ends the program on the spot.
void handleEarlySignal(int signal) {
  noteSignal(signal);
  ::ros::requestShutdown();
  std::signal(signal, SIG_DFL);
}

void handleSignals(void (*handler)(int)) {
  std::signal(SIGINT, handler);
  std::signal(SIGTERM, handler);
}

/// False if a signal came before there was a master.
bool waitForMaster(const std::string& node_name) {
  bool was_said = false;
  while (signal_received == 0 && !::ros::master::check()) {
    if (!was_said) {
      std::cerr << node_name << ": no ROS master at " << ::ros::master::getURI()
                << " (ROS_MASTER_URI), waiting for it; Ctrl-C ends\n";
    }
    was_said = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return signal_received == 0;
}

/// The first word that is neither ROS's (name:=value) nor one of `options`; "" if there is none.
std::string findUnknownOption(int argc, char** argv, const std::vector<std::string>& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool is_option = word.rfind("-", 0) == 0 && word.find(":=") == std::string::npos;
    if (!is_option || std::find(options.begin(), options.end(), word) != options.end()) continue;
    return word;
  }
  return "";
}

/// Says what was written, or why nothing. The exit status.
int concludeRun(ros_interface::EndGatherer& gatherer) {
  const auto reports = gatherer.collect();
  const std::string line = describeEnd(reports);
  const bool is_missing = std::any_of(reports.begin(), reports.end(),
                                      [](const EndReport& report) { return report.isMissing(); });
  if (is_missing) {
    ROS_ERROR_STREAM(line);
  } else if (!line.empty()) {
    ROS_INFO_STREAM(line);
  }
  return is_missing ? 1 : 0;
}

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
    if (signal_received != 0) return false;
    if (loader.load(names[i], nodelets[i].type, ::ros::names::getRemappings(), arguments)) continue;
    if (signal_received != 0) return false;
    ROS_FATAL_STREAM(names[i] << " (" << nodelets[i].type << ") did not load; see above for why");
    return false;
  }
  return true;
}

void spinUntilStopped() {
  while (::ros::ok() && signal_received == 0) {
    ::ros::getGlobalCallbackQueue()->callAvailable(::ros::WallDuration(0.05));
  }
}

/// Finishes the stages in order, while ROS is up, and unloads them, the last one first.
void endStages(nodelet::Loader& loader, std::vector<std::string> names) {
  if (::ros::ok()) {
    for (const auto& problem : finishStages(names).problems) {
      ROS_WARN_STREAM("at the end: " << problem);
    }
  }
  std::reverse(names.begin(), names.end());
  for (const auto& name : names) loader.unload(name);
}

int runWithMaster(const NodeletProgram& program, const std::vector<std::string>& arguments) {
  const std::vector<std::string> names = resolveNames(program.nodelets);
  EndGatherer gatherer;  // outlives the nodelets: those of a chain that did not start are silent
  nodelet::Loader loader;
  if (!loadAll(loader, program.nodelets, names, arguments)) {
    ::ros::shutdown();
    return signal_received != 0 ? 128 + signal_received : 1;
  }
  handleSignals(noteSignal);
  spinUntilStopped();
  endStages(loader, names);
  const int status = concludeRun(gatherer);
  ::ros::shutdown();
  return status;
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

int runNodelets(int argc, char** argv, const NodeletProgram& program,
                const std::vector<std::string>& options) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  for (const auto& argument : arguments) {
    if (argument != "--help" && argument != "-h") continue;
    std::cout << program.usage;
    return 0;
  }
  const std::string unknown = findUnknownOption(argc, argv, options);
  if (!unknown.empty()) {
    std::cerr << program.node_name << ": unknown option '" << unknown << "' (see --help)\n";
    return 2;
  }
  ::ros::init(argc, argv, program.node_name, ::ros::init_options::NoSigintHandler);
  handleSignals(handleEarlySignal);
  if (!waitForMaster(program.node_name)) {
    std::cerr << program.node_name << ": stopped while it waited for a ROS master\n";
    return 128 + signal_received;
  }
  return runWithMaster(program, arguments);
}

}  // namespace tsg::ros_interface
