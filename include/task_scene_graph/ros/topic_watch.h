// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/subscriber.h>

#include <chrono>
#include <string>
#include <vector>

#include "task_scene_graph/ros/stage_report.h"

namespace tsg::ros_interface {

/// Says by name which topics have been silent since the start, and which several publishers send
/// on, as robots do that share one. Not thread-safe: to be used from the
/// callbacks of one queue.
class TopicWatch {
 public:
  TopicWatch(StageReport& report, double patience_s);

  /// `name_in_code`: the name to remap; `type`: what is expected there, for the message. Returns
  /// the topic's number for `noteMessage`.
  std::size_t add(const ::ros::Subscriber& subscriber, const std::string& name_in_code,
                  const std::string& type = "");
  /// The number that the next `add` will return.
  std::size_t nextNumber() const { return topics_.size(); }
  /// The topic is read under another name from now on.
  void replace(std::size_t topic, const ::ros::Subscriber& subscriber);
  void noteMessage(std::size_t topic) { topics_[topic].num_messages++; }
  std::uint64_t numMessages(std::size_t topic) const { return topics_[topic].num_messages; }

  /// To be called about once a second of wall time.
  void check();

 private:
  struct Topic {
    ::ros::Subscriber subscriber;
    std::string name_in_code;
    std::string type;
    std::uint64_t num_messages = 0;
    int num_crowded_checks = 0;  ///< in a row with several publishers
  };
  void warnOfSeveralPublishers();
  std::string describeSilence(const Topic& topic) const;

  StageReport& report_;
  const double patience_s_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::vector<Topic> topics_;
};

}  // namespace tsg::ros_interface
