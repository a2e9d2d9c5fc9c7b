// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/topic_watch.h"

#include <ros/master.h>
#include <ros/time.h>

#include <sstream>

namespace tsg::ros_interface {
namespace {

constexpr int kMaxTopicsNamed = 5;
constexpr int kCrowdedChecks = 3;  // one publisher may take over from another

/// What the master knows that may explain why nobody sends: another type, other topics of the type.
std::string describeAlternatives(const std::string& topic, const std::string& type) {
  ::ros::master::V_TopicInfo published;
  if (type.empty() || !::ros::master::getTopics(published)) return "";
  std::string others;
  int num_named = 0;
  for (const auto& info : published) {
    if (info.name == topic && info.datatype != type) {
      return " (it is published as " + info.datatype + ", expected " + type + ")";
    }
    if (info.datatype != type || info.name == topic || num_named >= kMaxTopicsNamed) continue;
    others += (num_named++ == 0 ? "" : ", ") + info.name;
  }
  return others.empty() ? "" : " (topics of type " + type + ": " + others + ")";
}

}  // namespace

TopicWatch::TopicWatch(StageReport& report, double patience_s)
    : report_(report), patience_s_(patience_s) {}

std::size_t TopicWatch::add(const ::ros::Subscriber& subscriber, const std::string& name_in_code,
                            const std::string& type) {
  topics_.push_back({subscriber, name_in_code, type, 0, 0});
  return topics_.size() - 1;
}

void TopicWatch::replace(std::size_t topic, const ::ros::Subscriber& subscriber) {
  topics_[topic].subscriber = subscriber;
}

void TopicWatch::check() {
  const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - start_;
  if (waited.count() < patience_s_) return;
  if (::ros::Time::isSimTime() && ::ros::Time::now().isZero()) {
    report_.warn("/clock",
                 "use_sim_time is set, but nothing arrives on /clock (play the bag with --clock)");
  }
  warnOfSeveralPublishers();
  // One line for all of them: what is silent before the robot starts is not five things wrong.
  std::string silent;
  for (const auto& topic : topics_) {
    if (topic.num_messages > 0) continue;
    silent += (silent.empty() ? "" : "; ") + describeSilence(topic);
  }
  if (silent.empty()) return;
  std::ostringstream text;
  text << "no messages for " << patience_s_ << " s on " << silent;
  report_.warn("silent topics", text.str());
}

void TopicWatch::warnOfSeveralPublishers() {
  for (auto& topic : topics_) {
    const std::uint32_t count = topic.subscriber.getNumPublishers();
    topic.num_crowded_checks = count > 1 ? topic.num_crowded_checks + 1 : 0;
    if (topic.num_crowded_checks < kCrowdedChecks) continue;
    const std::string name = topic.subscriber.getTopic();
    report_.warn("publishers of " + name,
                 std::to_string(count) + " publishers send on " + name +
                     ", expected one: what they send is mixed (of several robots each needs its "
                     "own topics; launch argument robot)");
  }
}

std::string TopicWatch::describeSilence(const Topic& topic) const {
  const std::string name = topic.subscriber.getTopic();
  if (topic.subscriber.getNumPublishers() > 0)
    return name + ": it has a publisher that sends nothing";
  return name + ": nobody publishes it; remap '" + topic.name_in_code + "' to your topic" +
         describeAlternatives(name, topic.type);
}

}  // namespace tsg::ros_interface
