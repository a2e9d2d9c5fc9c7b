// SPDX-License-Identifier: BSD-3-Clause
#include "ros/bag_records.h"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/String.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "ros/bag_message.h"
#include "ros/bag_set.h"
#include "support.h"

namespace tsg::ros_interface {
namespace {

constexpr int kMessages = 6;

void writeBag(const std::string& path, rosbag::compression::CompressionType compression) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  bag.setCompression(compression);
  bag.setChunkThreshold(200);  // several chunks
  std_msgs::String message;
  for (int i = 0; i < kMessages; ++i) {
    message.data = "message " + std::to_string(i);
    bag.write(i % 2 == 0 ? "/even" : "/odd", ros::Time(10.0 + i), message);
  }
}

std::string readAll(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void writeAll(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

int countReadable(const std::string& path) {
  int count = 0;
  BagSet({path}).forEach({"/even", "/odd"}, [&](const BagMessage& message) {
    const auto text = message.instantiate<std_msgs::String>();  // null: of another type
    if (text != nullptr && text->data.substr(0, 8) == "message ") ++count;
    return true;
  });
  return count;
}

class BagRecords : public testing::TestWithParam<rosbag::compression::CompressionType> {};

TEST_P(BagRecords, OfAHealthyBagAreFound) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "healthy.bag").string();
  writeBag(path, GetParam());
  EXPECT_NO_THROW(checkBagRecords(path));
  EXPECT_EQ(countReadable(path), kMessages);
}

INSTANTIATE_TEST_SUITE_P(Compressions, BagRecords,
                         testing::Values(rosbag::compression::Uncompressed,
                                         rosbag::compression::BZ2, rosbag::compression::LZ4));

TEST(DamagedBagRecords, AnIndexBeyondItsChunkIsNamed) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "index.bag").string();
  writeBag(path, rosbag::compression::Uncompressed);
  std::string bytes = readAll(path);
  // The first index record ends with its only entry: a stamp of 8 bytes, and the offset.
  const std::string op_index = std::string("op=\x04", 4);
  const std::size_t record = bytes.find(op_index);
  ASSERT_NE(record, std::string::npos);
  const std::size_t stamp = bytes.find(std::string("\x0a\0\0\0\0\0\0\0", 8), record);
  ASSERT_NE(stamp, std::string::npos);
  const std::uint32_t beyond = 5'000'000;
  std::memcpy(&bytes[stamp + 8], &beyond, sizeof(beyond));
  writeAll(path, bytes);
  try {
    countReadable(path);
    FAIL() << "read";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("index.bag"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("begins at byte 5000000 of its chunk, where none does"),
              std::string::npos)
        << e.what();
  }
}

TEST(DamagedBagRecords, NoMemoryIsTakenForAListThatCannotBeThere) {
  sensor_msgs::Image image;
  image.data.assign(100, 7);
  const std::uint32_t size = ros::serialization::serializationLength(image);
  std::vector<std::uint8_t> bytes(size);
  ros::serialization::OStream out(bytes.data(), size);
  ros::serialization::serialize(out, image);
  CheckedMessage<sensor_msgs::Image> read;
  ros::serialization::IStream healthy(bytes.data(), size);
  ros::serialization::deserialize(healthy, read);
  EXPECT_EQ(read.message.data, image.data);

  const std::uint32_t announced = 3'500'000'000;
  std::memcpy(&bytes[size - 100 - sizeof(announced)], &announced, sizeof(announced));
  CheckedMessage<sensor_msgs::Image> damaged;
  ros::serialization::IStream stream(bytes.data(), size);
  EXPECT_THROW(ros::serialization::deserialize(stream, damaged),
               ros::serialization::StreamOverrunException);
  EXPECT_LT(damaged.message.data.capacity(), 1000U);
}

TEST(DamagedBagRecords, EveryByteMayBeWrong) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "byte.bag").string();
  writeBag(path, rosbag::compression::Uncompressed);
  const std::string healthy = readAll(path);
  int refused = 0;
  for (std::size_t i = 0; i < healthy.size(); ++i) {
    if (healthy[i] == ' ') continue;  // padding
    std::string damaged = healthy;
    damaged[i] = static_cast<char>(~damaged[i]);
    writeAll(path, damaged);
    try {
      countReadable(path);
    } catch (const std::exception&) {
      ++refused;  // whatever it says: nothing was read that is not there
    }
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace tsg::ros_interface
