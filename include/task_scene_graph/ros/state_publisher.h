// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/single_subscriber_publisher.h>

#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace tsg::ros_interface {

/// The newest value of something, for whoever subscribes whenever: what roscpp's latch is meant
/// for. To a subscriber that comes while a message is published the latch may send the message
/// before, and nothing after it; this sends it the newest besides, so some come twice. Latched
/// nevertheless: of several subscribers in one process roscpp tells the publisher of the first.
///
/// Late subscribers are served from the callback queue of the node handle.
template <typename Message>
class StatePublisher {
 public:
  StatePublisher() = default;  ///< of no topic: nothing may be published
  StatePublisher(ros::NodeHandle& handle, const std::string& topic)
      : state_(std::make_shared<State>()),
        publisher_(handle.advertise<Message>(
            topic, kQueueSize,
            [state = state_](const ros::SingleSubscriberPublisher& subscriber) {
              const std::lock_guard<std::mutex> lock(state->mutex);
              if (state->newest != nullptr) subscriber.publish(*state->newest);
            },
            ros::SubscriberStatusCallback(), ros::VoidConstPtr(), true)) {}

  void publish(Message message) const {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    state_->newest = boost::make_shared<const Message>(std::move(message));
    publisher_.publish(state_->newest);
  }

  std::uint32_t numSubscribers() const { return publisher_.getNumSubscribers(); }
  explicit operator bool() const { return state_ != nullptr; }

 private:
  static constexpr std::uint32_t kQueueSize = 10;
  struct State {
    std::mutex mutex;  ///< the newest is stored and sent at once
    boost::shared_ptr<const Message> newest;
  };

  std::shared_ptr<State> state_;  ///< shared with the callbacks under way
  ros::Publisher publisher_;
};

}  // namespace tsg::ros_interface
