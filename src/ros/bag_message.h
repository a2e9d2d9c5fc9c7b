// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/serialization.h>
#include <rosbag/message_instance.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace tsg::ros_interface {

/// A message that is read as CheckedStream does.
template <typename Message>
struct CheckedMessage {
  Message message;
};

/// Takes no memory for lists that are announced, but cannot be there: roscpp makes room for as many
/// elements as four damaged bytes say, up to gigabytes, before it finds that they are missing.
class CheckedStream : public ros::serialization::IStream {
 public:
  using IStream::IStream;

  template <typename T>
  void next(T& value) {
    ros::serialization::deserialize(*this, value);
  }
  template <typename T, typename Allocator>
  void next(std::vector<T, Allocator>& list) {
    std::uint32_t length = 0;
    if (getLength() >= sizeof(length)) std::memcpy(&length, getData(), sizeof(length));
    // An element has at least one byte.
    if (length > getLength()) ros::serialization::throwStreamOverrun();
    ros::serialization::deserialize(*this, list);
  }
};

/// A message of a bag, not read yet.
class BagMessage {
 public:
  explicit BagMessage(const rosbag::MessageInstance& instance) : instance_(instance) {}

  const std::string& getTopic() const { return instance_.getTopic(); }
  const std::string& getDataType() const { return instance_.getDataType(); }
  /// When it was recorded.
  ros::Time getTime() const { return instance_.getTime(); }
  /// Null if the message is of another type. @throws ros::serialization::StreamOverrunException if
  /// it is damaged
  template <typename Message>
  boost::shared_ptr<Message> instantiate() const {
    const auto checked = instance_.instantiate<CheckedMessage<Message>>();
    if (checked == nullptr) return nullptr;
    return boost::shared_ptr<Message>(checked, &checked->message);
  }

 private:
  const rosbag::MessageInstance& instance_;
};

}  // namespace tsg::ros_interface

namespace ros {
namespace message_traits {

template <typename Message>
struct MD5Sum<tsg::ros_interface::CheckedMessage<Message>> : MD5Sum<Message> {};
template <typename Message>
struct DataType<tsg::ros_interface::CheckedMessage<Message>> : DataType<Message> {};

}  // namespace message_traits

namespace serialization {

template <typename Message>
struct Serializer<tsg::ros_interface::CheckedMessage<Message>> {
  static void read(IStream& stream, tsg::ros_interface::CheckedMessage<Message>& checked) {
    tsg::ros_interface::CheckedStream checking(stream.getData(), stream.getLength());
    checking.next(checked.message);
  }
};

}  // namespace serialization
}  // namespace ros
