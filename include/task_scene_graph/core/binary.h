// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

/// Files of plain numbers, little-endian as all machines that ROS runs on.
namespace tsg {

/// Writes values one after another; what went wrong is the stream's to say.
class BinaryWriter {
 public:
  explicit BinaryWriter(std::ostream& stream) : stream_(stream) {}

  template <typename T>
  void put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    putBytes(&value, sizeof(T));
  }
  void putString(const std::string& text);
  /// A number of items and the items: of a type without pointers and padding.
  template <typename T>
  void putVector(const std::vector<T>& items) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(static_cast<std::uint64_t>(items.size()));
    putBytes(items.data(), items.size() * sizeof(T));
  }
  /// Rows, columns and the numbers, column by column.
  template <typename Derived>
  void putMatrix(const Eigen::PlainObjectBase<Derived>& matrix) {
    put(static_cast<std::uint32_t>(matrix.rows()));
    put(static_cast<std::uint32_t>(matrix.cols()));
    putBytes(matrix.data(),
             static_cast<std::size_t>(matrix.size()) * sizeof(typename Derived::Scalar));
  }
  void putBytes(const void* bytes, std::size_t size) {
    stream_.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(size));
  }

 private:
  std::ostream& stream_;
};

/// Reads what BinaryWriter wrote; whatever the bytes are, nothing is read beyond their end and
/// nothing larger than they can hold is allocated.
class BinaryReader {
 public:
  explicit BinaryReader(std::string bytes) : bytes_(std::move(bytes)) {}

  template <typename T>
  T get() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    getBytes(&value, sizeof(T));
    return value;
  }
  std::string getString();
  template <typename T>
  std::vector<T> getVector() {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<T> items(getCount(sizeof(T)));
    getBytes(items.data(), items.size() * sizeof(T));
    return items;
  }
  /// @throws std::runtime_error unless the matrix has the size that `matrix` is fixed to.
  template <typename Derived>
  void getMatrix(Eigen::PlainObjectBase<Derived>& matrix) {
    using Scalar = typename Derived::Scalar;
    const auto rows = get<std::uint32_t>();
    const auto cols = get<std::uint32_t>();
    const bool fits =
        isFixed(Derived::RowsAtCompileTime, rows) && isFixed(Derived::ColsAtCompileTime, cols);
    if (!fits) fail("a matrix of " + std::to_string(rows) + " x " + std::to_string(cols));
    requireBytes(std::uint64_t{rows} * cols, sizeof(Scalar));
    matrix.resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
    getBytes(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(Scalar));
  }
  /// A number of items that take at least `item_bytes` each. @throws std::runtime_error if there
  /// are not so many bytes left.
  std::size_t getCount(std::size_t item_bytes);
  void getBytes(void* bytes, std::size_t size);
  bool isAtEnd() const { return next_ == bytes_.size(); }

 private:
  static bool isFixed(int expected, std::uint32_t size) {
    return expected == Eigen::Dynamic || static_cast<std::uint32_t>(expected) == size;
  }
  void requireBytes(std::uint64_t count, std::size_t item_bytes) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::string bytes_;
  std::size_t next_ = 0;
};

/// Writes a file of a kind ("primitives") and version, whole or not at all (core/files.h); `write`
/// gives the content, which is compressed without loss. @throws as writeFileAtomically().
void writeBinaryFile(const std::filesystem::path& path, const std::string& kind,
                     std::uint32_t version, const std::function<void(BinaryWriter&)>& write);

/// Reads it back. @throws std::runtime_error naming the file, what was found and what was expected:
/// not there, another kind or version, damaged, or `read` threw or left something unread.
void readBinaryFile(const std::filesystem::path& path, const std::string& kind,
                    std::uint32_t version, const std::function<void(BinaryReader&)>& read);

/// Of a file's bytes, as zlib and PNG have it. @throws std::runtime_error naming the file.
std::uint32_t computeCrc32(const std::filesystem::path& path);

}  // namespace tsg
