// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/late_subscribers.h"

#include <gtest/gtest.h>
#include <ros/subscriber_link.h>
#include <std_msgs/String.h>

#include <boost/make_shared.hpp>
#include <thread>

#include "task_scene_graph/ros/byte_budget.h"

namespace tsg::ros_interface {
namespace {

/// A subscriber that takes messages when it is told to.
class SlowSubscriber : public ros::SubscriberLink {
 public:
  void drop() override {}
  std::string getTransportType() override { return "test"; }
  std::string getTransportInfo() override { return "test"; }
  void enqueueMessage(const ros::SerializedMessage& message, bool, bool) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    queue_.push_back(message);
    bytes_ += message.num_bytes;
    max_bytes_ = std::max(max_bytes_, bytes_);
  }
  bool takeOne() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (queue_.empty()) return false;
    bytes_ -= queue_.front().num_bytes;
    queue_.pop_front();
    ++num_taken_;
    return true;
  }
  std::size_t numCollected() const { return num_taken_; }
  std::size_t maxBytes() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return max_bytes_;
  }

 private:
  mutable std::mutex mutex_;
  std::deque<ros::SerializedMessage> queue_;
  std::size_t bytes_ = 0;
  std::size_t max_bytes_ = 0;
  std::atomic<std::size_t> num_taken_{0};
};

std_msgs::String makePart(std::size_t bytes) {
  std_msgs::String message;
  message.data.assign(bytes, 'x');
  return message;
}

TEST(PartSender, NeverHasMoreUnderWayThanItsLimitHoweverSlowTheSubscriberIs) {
  constexpr int kParts = 60;
  const auto link = boost::make_shared<SlowSubscriber>();
  const ros::SingleSubscriberPublisher subscriber(link);
  const std::atomic<bool> is_stopped{false};
  std::thread taker([&] {
    while (link->numCollected() < kParts) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (link->maxBytes() > PartSender::kMaxPartBytes) link->takeOne();
    }
  });
  PartSender sender(subscriber, is_stopped);
  for (int i = 0; i < kParts; ++i) {
    sender.send(makePart(900000));
    EXPECT_TRUE(sender.waitForRoom());
  }
  taker.join();
  EXPECT_LE(link->maxBytes(), PartSender::kMaxBytesUnderWay);
  EXPECT_GT(link->maxBytes(), PartSender::kMaxPartBytes);
  EXPECT_EQ(sender.bytesUnderWay(), 0U);
}

TEST(PartSender, ASubscriberThatTakesNothingIsGivenUp) {
  const auto link = boost::make_shared<SlowSubscriber>();
  const ros::SingleSubscriberPublisher subscriber(link);
  const std::atomic<bool> is_stopped{false};
  PartSender sender(subscriber, is_stopped, std::chrono::milliseconds(20));
  int num_sent = 1;
  for (sender.send(makePart(1000000)); sender.waitForRoom(); ++num_sent) {
    ASSERT_LT(num_sent, 100);
    sender.send(makePart(1000000));
  }
  EXPECT_TRUE(sender.wasGivenUp());
  EXPECT_LE(link->maxBytes(), PartSender::kMaxBytesUnderWay);
}

TEST(PartSender, TheEndOfTheProgramEndsWaiting) {
  const auto link = boost::make_shared<SlowSubscriber>();
  const ros::SingleSubscriberPublisher subscriber(link);
  std::atomic<bool> is_stopped{false};
  PartSender sender(subscriber, is_stopped, std::chrono::hours(1));
  for (int i = 0; i < 9; ++i) sender.send(makePart(1000000));
  std::thread stopper([&] { is_stopped = true; });
  EXPECT_FALSE(sender.waitForRoom());
  stopper.join();
  EXPECT_FALSE(sender.wasGivenUp());
}

TEST(ByteBudget, WhatDoesNotFitBesideWhatWaitsIsRefused) {
  ByteBudget budget(100);
  const auto first = budget.reserve(60);
  auto second = budget.reserve(40);
  EXPECT_NE(second, nullptr);
  EXPECT_EQ(budget.reserve(1), nullptr);
  EXPECT_EQ(budget.usedBytes(), 100U);
  second.reset();
  EXPECT_NE(budget.reserve(40), nullptr);
}

TEST(ByteBudget, OneItemAloneAlwaysFits) {
  ByteBudget budget(100);
  auto large = budget.reserve(1000);
  EXPECT_NE(large, nullptr);
  EXPECT_EQ(budget.reserve(1), nullptr);
  large.reset();
  EXPECT_EQ(budget.usedBytes(), 0U);
}

TEST(ByteBudget, BytesOfAFrameAreThoseOfItsImages) {
  RgbdFrame frame;
  frame.color.image = cv::Mat(10, 20, CV_8UC3);
  frame.depth.image = cv::Mat(10, 20, CV_16UC1);
  EXPECT_EQ(countBytes(frame), 10U * 20U * 5U);
}

}  // namespace
}  // namespace tsg::ros_interface
