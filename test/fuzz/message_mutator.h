// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/serialization.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "mutator.h"

namespace tsg::fuzz {

/// Visits the fields of any message, by way of its generated serializer, and changes the
/// `target`-th.
class FieldChanger {
 public:
  /// @param target  beyond the last: nothing is changed, and `count` tells how many there are
  FieldChanger(Mutator& mutator, std::size_t target) : mutator_(mutator), target_(target) {}

  std::size_t count() const { return count_; }

  template <typename T>
  void next(T& field) {
    if constexpr (std::is_arithmetic_v<T>) {
      if (isTarget()) changeNumber(field);
    } else if constexpr (std::is_same_v<T, std::string>) {
      if (isTarget()) changeText(field);
    } else if constexpr (std::is_same_v<T, ros::Time>) {
      next(field.sec);
      next(field.nsec);
    } else {
      visit(field, 0);
    }
  }

 private:
  bool isTarget() { return count_++ == target_; }

  template <typename T>
  void visit(std::vector<T>& values, int) {
    if (isTarget()) changeLength(values);
    visitElements(values);
  }
  template <typename T, std::size_t N>
  void visit(boost::array<T, N>& values, int) {
    visitElements(values);
  }
  template <typename Message>
  void visit(Message& message, long) {
    ros::serialization::Serializer<Message>::template allInOne<FieldChanger, Message&>(*this,
                                                                                       message);
  }

  /// Of many numbers, one stands for all.
  template <typename Values>
  void visitElements(Values& values) {
    using Element = typename Values::value_type;
    if constexpr (std::is_arithmetic_v<Element>) {
      if (values.empty()) return;
      if (isTarget()) changeNumber(values[mutator_.pick(values.size())]);
    } else {
      for (auto& value : values) next(value);
    }
  }

  template <typename T>
  void changeNumber(T& value) {
    if constexpr (std::is_floating_point_v<T>) {
      const double wanted = mutator_.pickDouble();
      const bool is_large = std::abs(wanted) > std::numeric_limits<T>::max();
      value = is_large && std::isfinite(wanted) ? std::numeric_limits<T>::max()
                                                : static_cast<T>(wanted);
    } else {
      value = static_cast<T>(mutator_.pickInteger());
    }
  }
  void changeText(std::string& text) {
    static const std::vector<std::string> texts{"",
                                                "/",
                                                "map",
                                                "8UC3",
                                                "8UC5",
                                                "16UC1",
                                                "mono16",
                                                "32FC1",
                                                "64FC1",
                                                "bgr8",
                                                "rgba8",
                                                "8UC",
                                                "32SC2",
                                                "jpeg",
                                                "png",
                                                "rvl",
                                                "plumb_bob",
                                                "fisheye",
                                                "rational_polynomial",
                                                "bayer_rggb8",
                                                "yuv422",
                                                "32FC1; compressedDepth rvl",
                                                "16UC1; compressedDepth png",
                                                "\xff",
                                                "world",
                                                "camera"};
    if (mutator_.isOneIn(3)) {
      mutator_.mutateBytes(texts, text);
    } else {
      text = mutator_.pickFrom(texts);
    }
  }
  template <typename T>
  void changeLength(std::vector<T>& values) {
    if (values.empty() || mutator_.isOneIn(3)) {
      values.resize(mutator_.pickFrom(std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 8, 9, 12, 100}));
    } else if (mutator_.isOneIn(2)) {
      values.pop_back();
    } else {
      values.push_back(values[mutator_.pick(values.size())]);
    }
  }

  Mutator& mutator_;
  std::size_t target_;
  std::size_t count_ = 0;
};

/// Changes one to four fields of a message.
template <typename Message>
void mutateMessage(Mutator& mutator, Message& message) {
  for (std::size_t i = 1 + mutator.pick(4); i > 0; --i) {
    FieldChanger counter(mutator, std::numeric_limits<std::size_t>::max());
    counter.next(message);
    FieldChanger changer(mutator, mutator.pick(counter.count()));
    changer.next(message);
  }
}

/// The message as it travels.
template <typename Message>
std::string toBytes(const Message& message) {
  std::string bytes(ros::serialization::serializationLength(message), '\0');
  ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                     static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

template <typename Message>
std::string makeMutated(Mutator& mutator, Message message) {
  mutateMessage(mutator, message);
  return toBytes(message);
}

template <typename Message>
boost::shared_ptr<Message> fromBytes(const std::string& bytes) {
  auto message = boost::make_shared<Message>();
  // The serializers take mutable bytes, and leave them as they are.
  auto* data = reinterpret_cast<std::uint8_t*>(const_cast<char*>(bytes.data()));
  ros::serialization::IStream stream(data, static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::deserialize(stream, *message);
  return message;
}

}  // namespace tsg::fuzz
