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
#include "task_scene_graph/ros/flush.h"
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

// roslaunch kills what has not ended after 15 s.
constexpr double kFlushTimeout_s = 11.0;
constexpr double kFlushQuiet_s = 8.0;
constexpr std::chrono::seconds kOwnerTimeout{13};

/// So that nothing in the chain is lost, while ROS is up.
void flushAtEnd(const NodeletProgram& program, const std::vector<std::string>& names) {
  const auto start = std::chrono::steady_clock::now();
  const auto patience = Patience::from(kFlushTimeout_s, kFlushQuiet_s);
  const std::vector<std::string> to_flush =
      program.has_map_owner ? std::vector<std::string>{names.back()} : names;
  for (const auto& line : flushStages(to_flush, msg::FlushRequest::END, patience).missing) {
    ROS_WARN_STREAM("at the end, not in the map: " << line);
  }
  if (!program.has_map_owner) {
    waitForMapOwner(::ros::names::resolve("scene_graph"), start + kOwnerTimeout);
  }
}

/// Unloads the stages, the last one first.
void endStages(nodelet::Loader& loader, const NodeletProgram& program,
               std::vector<std::string> names) {
  if (::ros::ok()) flushAtEnd(program, names);
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
  endStages(loader, program, names);
  const int status = concludeRun(gatherer);
  ::ros::shutdown();
  return status;
}

}  // namespace

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
