// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/flush.h"

#include <ros/ros.h>

#include <algorithm>
#include <mutex>
#include <thread>
#include <utility>

namespace tsg::ros_interface {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kQuietUntilAlone{3};

/// FlushGuards of this process.
struct Guards {
  std::mutex mutex;
  int num_alive = 0;
  Clock::time_point newest;

  static Guards& instance() {
    static Guards guards;
    return guards;
  }
  bool areQuiet() {
    const std::lock_guard<std::mutex> lock(mutex);
    return num_alive == 0 && Clock::now() - newest > kQuietUntilAlone;
  }
};

float secondsUntil(Clock::time_point deadline) {
  const std::chrono::duration<float> rest = deadline - Clock::now();
  return std::max(0.1F, rest.count());
}

}  // namespace

FlushedStages flushStages(const std::vector<std::string>& stages, std::uint8_t mode,
                          const Patience& patience) {
  FlushedStages result;
  for (const auto& stage : stages) {
    const std::string service = ::ros::names::append(stage, "flush");
    msg::Flush call;
    call.request.mode = mode;
    call.request.sequence = std::exchange(result.sequence, 0);
    call.request.place_sequence = std::exchange(result.place_sequence, 0);
    if (!::ros::service::exists(service, false)) {
      result.absent.push_back(stage);
      continue;
    }
    call.request.timeout_s = secondsUntil(patience.deadline);
    call.request.quiet_s = std::chrono::duration<float>(patience.quiet).count();
    if (!::ros::service::call(service, call)) {
      result.missing.push_back(stage + ": the service " + service + " failed");
      continue;
    }
    result.contents.push_back(stage + ": " + call.response.content);
    for (const auto& line : call.response.missing) result.missing.push_back(stage + ": " + line);
    result.sequence = call.response.sequence;
    result.place_sequence = call.response.place_sequence;
  }
  return result;
}

FlushGuard::FlushGuard() {
  Guards& guards = Guards::instance();
  const std::lock_guard<std::mutex> lock(guards.mutex);
  ++guards.num_alive;
}

FlushGuard::~FlushGuard() {
  Guards& guards = Guards::instance();
  const std::lock_guard<std::mutex> lock(guards.mutex);
  --guards.num_alive;
  guards.newest = Clock::now();
}

void waitForMapOwner(const std::string& owner, Clock::time_point deadline) {
  const std::string service = ::ros::names::append(owner, "flush");
  while (Clock::now() < deadline && !Guards::instance().areQuiet() &&
         ::ros::service::exists(service, false)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

}  // namespace tsg::ros_interface
