// SPDX-License-Identifier: BSD-3-Clause
#include "rvl.h"

#include <cstring>

namespace tsg::ros_interface {
namespace {

constexpr std::uint64_t kMaxPixels = 1U << 26U;
constexpr std::size_t kHeaderBytes = 8;
constexpr std::uint32_t kMaxShift = 30;

/// Numbers of variable length: nibbles, least significant first, the highest bit says "goes on".
/// Nibbles are packed into words of 32 bits, from the highest down.
class NibbleReader {
 public:
  NibbleReader(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  std::uint32_t readNumber() {
    std::uint32_t value = 0;
    for (std::uint32_t shift = 0; shift <= kMaxShift; shift += 3) {
      const std::uint32_t nibble = readNibble();
      value |= (nibble & 7U) << shift;
      if ((nibble & 8U) == 0) return value;
    }
    is_bad_ = true;
    return value;
  }
  bool isBad() const { return is_bad_; }

 private:
  std::uint32_t readNibble() {
    if (num_left_ == 0) {
      if (position_ + sizeof(word_) > size_) {
        is_bad_ = true;
        return 0;
      }
      std::memcpy(&word_, data_ + position_, sizeof(word_));
      position_ += sizeof(word_);
      num_left_ = 8;
    }
    const std::uint32_t nibble = word_ >> 28U;
    word_ <<= 4U;
    --num_left_;
    return nibble;
  }

  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t position_ = 0;
  std::uint32_t word_ = 0;
  int num_left_ = 0;
  bool is_bad_ = false;
};

/// Difference out of 0, -1, 1, -2, 2, ... as 0, 1, 2, 3, 4, ...
int fromZigzag(std::uint32_t value) {
  return static_cast<int>(value >> 1U) ^ -static_cast<int>(value & 1U);
}

bool decodePixels(NibbleReader& reader, std::uint16_t* pixels, std::size_t count) {
  std::size_t done = 0;
  int previous = 0;
  while (done < count) {
    done += reader.readNumber();  // zeros
    const std::uint32_t num_values = reader.readNumber();
    if (reader.isBad() || done > count || num_values > count - done) return false;
    for (std::uint32_t i = 0; i < num_values; ++i) {
      previous += fromZigzag(reader.readNumber());
      pixels[done++] = static_cast<std::uint16_t>(previous);
    }
  }
  return !reader.isBad();
}

}  // namespace

cv::Mat decodeRvl(const std::uint8_t* data, std::size_t size) {
  if (size < kHeaderBytes) return {};
  std::uint32_t cols = 0;
  std::uint32_t rows = 0;
  std::memcpy(&cols, data, sizeof(cols));
  std::memcpy(&rows, data + sizeof(cols), sizeof(rows));
  const std::uint64_t count = static_cast<std::uint64_t>(cols) * rows;
  if (count == 0 || count > kMaxPixels || cols > kMaxPixels || rows > kMaxPixels) return {};
  cv::Mat depth = cv::Mat::zeros(static_cast<int>(rows), static_cast<int>(cols), CV_16UC1);
  NibbleReader reader(data + kHeaderBytes, size - kHeaderBytes);
  if (!decodePixels(reader, depth.ptr<std::uint16_t>(), static_cast<std::size_t>(count))) return {};
  return depth;
}

}  // namespace tsg::ros_interface
