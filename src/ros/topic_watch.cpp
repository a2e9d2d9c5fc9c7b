// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/topic_watch.h"

#include <ros/master.h>
#include <ros/time.h>

#include <sstream>

namespace tsg::ros_interface {
namespace {

constexpr int kMaxTopicsNamed = 5;

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
  topics_.push_back({subscriber, name_in_code, type, 0});
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
  for (const auto& topic : topics_) {
    if (topic.num_messages > 0) continue;
    report_.warn(topic.subscriber.getTopic(), describeSilence(topic));
  }
}

std::string TopicWatch::describeSilence(const Topic& topic) const {
  std::ostringstream text;
  text << "no messages on " << topic.subscriber.getTopic() << " for " << patience_s_ << " s: ";
  if (topic.subscriber.getNumPublishers() == 0) {
    text << "nobody publishes it; remap '" << topic.name_in_code << "' to your topic"
         << describeAlternatives(topic.subscriber.getTopic(), topic.type);
  } else {
    text << "it has a publisher that sends nothing";
  }
  return text.str();
}

}  // namespace tsg::ros_interface
