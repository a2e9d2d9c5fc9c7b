// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/serialization.h>
#include <ros/single_subscriber_publisher.h>
#include <ros/spinner.h>

#include <atomic>
#include <boost/shared_array.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <utility>

#include "task_scene_graph/ros/stage_report.h"

namespace tsg::ros_interface {

/// A message that is serialised already.
struct SerializedPart {
  ros::SerializedMessage message;
};
/// What SingleSubscriberPublisher::publish() finds in the place of roscpp's own template.
inline ros::SerializedMessage serializeMessage(const SerializedPart& part) { return part.message; }

/// Sends one subscriber all there is in parts, no faster than it takes them: roscpp itself would
/// queue any number of bytes, or drop the oldest message.
class PartSender {
 public:
  static constexpr std::size_t kMaxPartBytes = 1 << 20;  ///< parts should be no larger
  static constexpr std::size_t kMaxBytesUnderWay = 8 << 20;

  /// @param is_stopped  ends waiting; must outlive this object
  /// @param patience    a subscriber that takes nothing for so long is given up
  PartSender(const ros::SingleSubscriberPublisher& subscriber, const std::atomic<bool>& is_stopped,
             std::chrono::milliseconds patience = std::chrono::seconds(10))
      : subscriber_(subscriber), is_stopped_(is_stopped), patience_(patience) {}

  /// Queues a part. Never blocks, so it may be called under the lock that keeps parts and changes
  /// in order.
  template <typename Message>
  void send(const Message& message) {
    const SerializedPart part{ros::serialization::serializeMessage(message)};
    under_way_.push_back({part.message.buf, part.message.num_bytes});
    subscriber_.publish(part);
  }

  /// Waits until another part of kMaxPartBytes may be sent. False if none should be: the subscriber
  /// was given up, or the program ends. Not to be called under a lock.
  bool waitForRoom();

  std::size_t bytesUnderWay();
  std::string subscriberName() const { return subscriber_.getSubscriberName(); }
  bool wasGivenUp() const { return was_given_up_; }

 private:
  struct Buffer {
    boost::shared_array<std::uint8_t> bytes;  ///< roscpp shares it until the subscriber has it
    std::size_t size = 0;
  };

  const ros::SingleSubscriberPublisher& subscriber_;
  const std::atomic<bool>& is_stopped_;
  std::chrono::milliseconds patience_;
  std::deque<Buffer> under_way_;
  bool was_given_up_ = false;
};

/// Serves the subscribers that come late to topics of which they need all there is: in threads of
/// its own, so that nobody waits for a subscriber.
class LateSubscribers {
 public:
  /// Sends one subscriber all there is.
  using Serve = std::function<void(PartSender&)>;

  /// @param report  is told of subscribers that were given up, and of errors; must outlive this
  explicit LateSubscribers(StageReport& report);
  ~LateSubscribers() { stop(); }
  LateSubscribers(const LateSubscribers&) = delete;
  LateSubscribers& operator=(const LateSubscribers&) = delete;

  /// Advertises a topic whose subscribers are each served once, when they come.
  /// @param serve  called from a thread of this object, also from several at once; what it uses
  ///               must live until stop()
  /// @param is_latched  besides, subscribers in this process are sent the last message published
  template <typename Message>
  ros::Publisher advertise(ros::NodeHandle& handle, const std::string& topic,
                           std::uint32_t queue_size, Serve serve, bool is_latched = false) {
    ros::AdvertiseOptions options;
    options.init<Message>(
        topic, queue_size,
        [this, topic, serve = std::move(serve)](const ros::SingleSubscriberPublisher& subscriber) {
          serveOne(topic, serve, subscriber);
        });
    options.callback_queue = &queue_;
    options.latch = is_latched;
    return handle.advertise(options);
  }

  /// Ends serving. Subscribers that come from now on are sent nothing.
  void stop();

 private:
  void serveOne(const std::string& topic, const Serve& serve,
                const ros::SingleSubscriberPublisher& subscriber);

  StageReport& report_;
  std::atomic<bool> is_stopped_{false};
  ros::CallbackQueue queue_;
  ros::AsyncSpinner spinner_;
};

}  // namespace tsg::ros_interface
