// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/late_subscribers.h"

#include <exception>
#include <thread>

namespace tsg::ros_interface {
namespace {

constexpr std::uint32_t kThreads = 2;  // a slow subscriber does not hold up all others
constexpr std::chrono::milliseconds kPollPeriod(2);

}  // namespace

std::size_t PartSender::bytesUnderWay() {
  while (!under_way_.empty() && under_way_.front().bytes.use_count() == 1) under_way_.pop_front();
  std::size_t bytes = 0;
  for (const auto& buffer : under_way_) bytes += buffer.size;
  return bytes;
}

bool PartSender::waitForRoom() {
  auto last_progress = std::chrono::steady_clock::now();
  std::size_t last_count = under_way_.size();
  while (!is_stopped_) {
    if (bytesUnderWay() + kMaxPartBytes <= kMaxBytesUnderWay) return true;
    const auto now = std::chrono::steady_clock::now();
    if (under_way_.size() < last_count) last_progress = now;
    last_count = under_way_.size();
    was_given_up_ = now - last_progress > patience_;
    if (was_given_up_) return false;
    std::this_thread::sleep_for(kPollPeriod);
  }
  return false;
}

LateSubscribers::LateSubscribers(StageReport& report)
    : report_(report), spinner_(kThreads, &queue_) {
  spinner_.start();
}

void LateSubscribers::stop() {
  is_stopped_ = true;
  spinner_.stop();
}

void LateSubscribers::serveOne(const std::string& topic, const Serve& serve,
                               const ros::SingleSubscriberPublisher& subscriber) {
  PartSender sender(subscriber, is_stopped_);
  const std::string who = "'" + sender.subscriberName() + "', which subscribed to '" + topic + "'";
  try {
    serve(sender);
    if (sender.wasGivenUp()) {
      report_.warn("late subscriber", who + ", takes no messages: it was not sent all there is");
    }
  } catch (const std::exception& e) {
    report_.warn("late subscriber", who + ", was not sent all there is: " + e.what());
  }
}

}  // namespace tsg::ros_interface
