// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/message_traits.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bag_message.h"

namespace tsg::ros_interface {

/// Bags that are read as one, in order of recording time.
class BagSet {
 public:
  /// @throws std::runtime_error naming the file, what is wrong with it (a folder, a ROS 2 bag, not
  /// closed, cut short, empty) and what to do.
  explicit BagSet(const std::vector<std::string>& paths);

  using OnMessage = std::function<bool(const BagMessage&)>;
  /// Calls `on_message` for each message of the topics until it returns false.
  void forEach(const std::vector<std::string>& topics, const OnMessage& on_message);
  std::size_t count(const std::string& topic);
  /// Topics whose messages are of one of these types, by name.
  std::vector<std::string> findTopics(const std::vector<std::string>& types);
  /// Type of a topic's messages; "" if there is none.
  std::string typeOf(const std::string& topic);
  /// A message of another type or version cannot be read, and rosbag says nothing.
  /// @throws std::runtime_error naming the topic, what it holds and what was expected.
  template <typename Message>
  void requireVersion(const std::string& topic, const std::string& remedy) {
    requireVersion(topic, ros::message_traits::datatype<Message>(),
                   ros::message_traits::md5sum<Message>(), remedy);
  }
  /// One line for each topic, with its type.
  std::string listTopics();
  /// The files' names for messages: "bag 'a.bag'" or "bags 'a.bag', 'b.bag'".
  const std::string& name() const { return name_; }

 private:
  void requireVersion(const std::string& topic, const std::string& type, const std::string& md5,
                      const std::string& remedy);
  void addTo(rosbag::View& view, const std::vector<std::string>& topics);
  std::map<std::string, std::string> mapTypes();

  std::vector<std::unique_ptr<rosbag::Bag>> bags_;
  std::string name_;
};

}  // namespace tsg::ros_interface
