// SPDX-License-Identifier: BSD-3-Clause
#include "bag_records.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <vector>

namespace tsg::ros_interface {
namespace {

constexpr std::uint64_t kFirstRecord = 13;  // after "#ROSBAG V2.0\n"
constexpr std::uint64_t kLength = 4;        // bytes of a length
constexpr std::uint64_t kLargestHeader = 1U << 24U;
constexpr std::uint64_t kIndexEntry = 12;  // a stamp, and an offset into the chunk

enum class Op : std::uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kInfo = 6,
  kConnection = 7
};

[[noreturn]] void fail(std::uint64_t position, const std::string& what) {
  throw std::runtime_error("at byte " + std::to_string(position) + ": " + what);
}

/// Numbers of a bag have the byte order of x86 and ARM.
template <typename T>
T toNumber(const std::string& bytes, std::uint64_t position, const std::string& name) {
  T number{};
  if (bytes.size() != sizeof(number)) {
    fail(position, "'" + name + "' has " + std::to_string(bytes.size()) + " bytes, expected " +
                       std::to_string(sizeof(number)));
  }
  std::memcpy(&number, bytes.data(), sizeof(number));
  return number;
}

using Fields = std::map<std::string, std::string>;

/// @param position  of the record, for what is said of it
Fields parseFields(const std::string& bytes, std::uint64_t position) {
  Fields fields;
  for (std::uint64_t at = 0; at < bytes.size();) {
    if (bytes.size() - at < kLength) fail(position, "a field of the header has no length");
    const auto size = toNumber<std::uint32_t>(bytes.substr(at, kLength), position, "length");
    at += kLength;
    const std::uint64_t equals = bytes.find('=', at);
    if (size > bytes.size() - at || equals >= at + size) {
      fail(position, "a field of the header is not of the form 'name=value'");
    }
    fields[bytes.substr(at, equals - at)] = bytes.substr(equals + 1, at + size - equals - 1);
    at += size;
  }
  return fields;
}

/// A header of named fields, then data.
struct Record {
  std::uint64_t position = 0;
  Fields fields;
  std::uint64_t data_position = 0;
  std::uint64_t data_size = 0;

  std::uint64_t end() const { return data_position + data_size; }
  template <typename T>
  T number(const std::string& name) const {
    const auto found = fields.find(name);
    if (found == fields.end()) fail(position, "the record has no '" + name + "'");
    return toNumber<T>(found->second, position, name);
  }
  bool is(Op op) const { return number<std::uint8_t>("op") == static_cast<std::uint8_t>(op); }
};

class BagChecker {
 public:
  explicit BagChecker(const std::string& path)
      : file_(path, std::ios::binary), size_(std::filesystem::file_size(path)) {}

  void check() {
    const Record head = require(kFirstRecord, Op::kBagHeader);
    const auto encryptor = head.fields.find("encryptor");
    is_encrypted_ = encryptor != head.fields.end() && !encryptor->second.empty();
    auto position = head.number<std::uint64_t>("index_pos");
    if (position == 0) return;  // it was not closed: there is no index yet
    const auto connections = head.number<std::uint32_t>("conn_count");
    for (std::uint32_t i = 0; i < connections; ++i) position = readRecord(position, size_).end();
    const auto chunks = head.number<std::uint32_t>("chunk_count");
    for (std::uint32_t i = 0; i < chunks; ++i) {
      const Record info = require(position, Op::kInfo);
      checkChunk(info.number<std::uint64_t>("chunk_pos"), info.number<std::uint32_t>("count"));
      position = info.end();
    }
  }

 private:
  std::string readBytes(std::uint64_t position, std::uint64_t count, std::uint64_t limit) {
    if (position > limit || count > limit - position) {
      fail(position, std::to_string(count) + " bytes are announced, but " +
                         (limit == size_ ? "the file" : "the chunk") + " ends at byte " +
                         std::to_string(limit));
    }
    std::string bytes(count, '\0');
    file_.seekg(static_cast<std::streamoff>(position));
    if (!file_.read(bytes.data(), static_cast<std::streamsize>(count))) {
      fail(position, "the file cannot be read");
    }
    return bytes;
  }
  std::uint64_t readLength(std::uint64_t position, std::uint64_t limit) {
    return toNumber<std::uint32_t>(readBytes(position, kLength, limit), position, "length");
  }

  /// @param limit  where what the record is in ends
  Record readRecord(std::uint64_t position, std::uint64_t limit) {
    Record record;
    record.position = position;
    const std::uint64_t header_size = readLength(position, limit);
    if (header_size > kLargestHeader) {
      fail(position, "the header would have " + std::to_string(header_size) + " bytes");
    }
    const std::string header = readBytes(position + kLength, header_size, limit);
    record.fields = parseFields(header, position);
    const std::uint64_t after = position + kLength + header.size();
    record.data_size = readLength(after, limit);
    record.data_position = after + kLength;
    if (record.data_size > limit - record.data_position) {
      fail(position,
           "the data is " + std::to_string(record.data_size) + " bytes, beyond what it is in");
    }
    if (!is_encrypted_ && record.fields.count("op") > 0 && record.is(Op::kConnection)) {
      parseFields(readBytes(record.data_position, record.data_size, limit), position);
    }
    return record;
  }
  Record require(std::uint64_t position, Op op) {
    Record record = readRecord(position, size_);
    if (record.is(op)) return record;
    fail(position, "the record is of another kind than expected (op " +
                       std::to_string(record.number<std::uint8_t>("op")) + ", not " +
                       std::to_string(static_cast<int>(op)) + ")");
  }

  /// Where the messages in a chunk that is not compressed begin, from the chunk's own beginning.
  std::vector<std::uint32_t> listMessages(const Record& chunk) {
    std::vector<std::uint32_t> starts;
    for (std::uint64_t position = chunk.data_position; position < chunk.end();) {
      const Record record = readRecord(position, chunk.end());
      if (record.is(Op::kMessage)) {
        starts.push_back(static_cast<std::uint32_t>(position - chunk.data_position));
      }
      position = record.end();
    }
    return starts;  // ascending
  }

  void checkChunk(std::uint64_t position, std::uint32_t num_indices) {
    const Record chunk = require(position, Op::kChunk);
    const auto compression = chunk.fields.find("compression");
    const bool is_plain =
        !is_encrypted_ && compression != chunk.fields.end() && compression->second == "none";
    const std::vector<std::uint32_t> starts =
        is_plain ? listMessages(chunk) : std::vector<std::uint32_t>();
    const auto size = chunk.number<std::uint32_t>("size");
    const auto isInside = [&](std::uint32_t offset) {
      return is_plain ? std::binary_search(starts.begin(), starts.end(), offset)
                      : offset + 2 * kLength <= size;
    };
    std::uint64_t at = chunk.end();
    for (std::uint32_t i = 0; i < num_indices; ++i) {
      const Record index = require(at, Op::kIndex);
      checkIndex(index, isInside);
      at = index.end();
    }
  }

  template <typename IsInside>
  void checkIndex(const Record& index, const IsInside& isInside) {
    const auto count = index.number<std::uint32_t>("count");
    if (index.data_size != count * kIndexEntry) {
      fail(index.position, "the index has " + std::to_string(index.data_size) + " bytes for " +
                               std::to_string(count) + " messages");
    }
    const std::string data = readBytes(index.data_position, index.data_size, size_);
    for (std::uint64_t i = 0; i < count; ++i) {
      std::uint32_t offset = 0;
      std::memcpy(&offset, data.data() + (i + 1) * kIndexEntry - sizeof(offset), sizeof(offset));
      if (isInside(offset)) continue;
      fail(index.position, "the index says that a message begins at byte " +
                               std::to_string(offset) + " of its chunk, where none does");
    }
  }

  std::ifstream file_;
  std::uint64_t size_;
  bool is_encrypted_ = false;
};

}  // namespace

void checkBagRecords(const std::string& path) { BagChecker(path).check(); }

}  // namespace tsg::ros_interface
