// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/single_subscriber_publisher.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

namespace tsg::ros_interface {

/// The newest value of something, for whoever subscribes whenever: what roscpp's latch is meant
/// for. To a subscriber that comes while a message is published the latch may send the message
/// before, and nothing after it; so this publishes the newest once more when somebody comes.
/// Latched nevertheless: of several subscribers in one process roscpp tells the publisher of the
/// first. Always serialised: roscpp hands a pointer to subscribers in this process at once, past
/// older messages that wait in its queue and come after it then.
///
/// Who comes is heard of in the callback queue of the node handle.
template <typename Message>
class StatePublisher {
 public:
  StatePublisher() = default;  ///< of no topic: nothing may be published
  StatePublisher(ros::NodeHandle& handle, const std::string& topic)
      : state_(std::make_shared<State>()) {
    const auto publishAgain = [weak = std::weak_ptr<State>(state_)](const auto&) {
      const auto state = weak.lock();
      if (state == nullptr) return;
      const std::lock_guard<std::mutex> lock(state->mutex);
      if (state->newest) state->publisher.publish(*state->newest);
    };
    const std::lock_guard<std::mutex> lock(state_->mutex);
    state_->publisher =
        handle.advertise<Message>(topic, kQueueSize, publishAgain, ros::SubscriberStatusCallback(),
                                  ros::VoidConstPtr(), true);
  }

  void publish(Message message) const {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    state_->newest = std::move(message);
    state_->publisher.publish(*state_->newest);
  }

  std::uint32_t numSubscribers() const { return state_->publisher.getNumSubscribers(); }
  explicit operator bool() const { return state_ != nullptr; }

 private:
  static constexpr std::uint32_t kQueueSize = 10;
  struct State {
    std::mutex mutex;
    ros::Publisher publisher;
    std::optional<Message> newest;
  };

  std::shared_ptr<State> state_;
};

}  // namespace tsg::ros_interface
