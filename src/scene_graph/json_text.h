// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "task_scene_graph/core/embedding.h"

namespace tsg::scene_graph {

/// Part of a JSON text: one value, without spaces around it.
struct JsonSpan {
  std::size_t begin = 0;
  std::size_t end = 0;

  std::size_t size() const { return end - begin; }
};

struct JsonField {
  std::string key;
  JsonSpan value;
};

/// The fields of a JSON object in their order; of those of one name the last.
class JsonObject {
 public:
  void add(std::string key, JsonSpan value);
  /// Null if there is none. Points into this object.
  const JsonSpan* find(std::string_view key) const&;
  const JsonSpan* find(std::string_view key) const&& = delete;
  const std::vector<JsonField>& fields() const { return fields_; }

 private:
  std::size_t findIndex(std::string_view key) const;  ///< fields_.size() if there is none

  std::vector<JsonField> fields_;
  std::map<std::string, std::size_t, std::less<>> index_;  ///< by key, where there are many
};

/// A JSON file as it stands in memory: checked from end to end, but not taken apart. A scene graph
/// of 100,000 primitives is a gigabyte of numbers; of these only the embeddings are read, straight
/// from the text, and the rest goes to the output as it came.
///
/// Numbers that Python's json module writes and JSON has not (NaN, Infinity, 1e999) count as null.
class JsonText {
 public:
  /// Reads and checks a file. O(bytes), about one and a half nanoseconds each.
  /// @throws std::runtime_error saying what the file is instead: absent, packed, a web page, cut
  /// off, nested deeper than 256 levels, no JSON (line, column, what is wrong). The path is not in
  /// it.
  static JsonText read(const std::string& path);
  /// @throws as read(), for a text.
  explicit JsonText(const std::string& text);

  /// The whole value.
  JsonSpan root() const { return root_; }
  std::size_t numOddNumbers() const { return odd_.size(); }

  bool isObject(JsonSpan value) const { return text_[value.begin] == '{'; }
  bool isArray(JsonSpan value) const { return text_[value.begin] == '['; }
  bool isNull(JsonSpan value) const;
  /// The fields of an object; none of any other value. O(fields).
  JsonObject readObject(JsonSpan value) const;
  /// The elements of an array; none of any other value. O(elements).
  std::vector<JsonSpan> readArray(JsonSpan value) const;

  /// A whole number from 0 to 2^64 - 1; nothing for any other value.
  std::optional<std::uint64_t> readUnsigned(JsonSpan value) const;
  /// A whole number that an int64 can hold; nothing for any other value.
  std::optional<std::int64_t> readInteger(JsonSpan value) const;
  /// Nothing for any other value than a number.
  std::optional<double> readNumber(JsonSpan value) const;
  /// An array of numbers as floats, each the nearest to its double; nothing for any other value.
  std::optional<Embedding> readFloats(JsonSpan value) const;

  /// The text of a value, with null in the place of odd numbers.
  std::string copy(JsonSpan value) const;
  void write(JsonSpan value, std::ostream& out) const;

 private:
  friend class JsonChecker;

  /// @param buffer  of `size` characters and a zero
  JsonText(std::unique_ptr<char[]> buffer, std::size_t size);
  std::size_t skipSpace(std::size_t at) const;
  std::size_t skipString(std::size_t at) const;
  using Containers = std::vector<JsonSpan>;
  /// Where a value ends. @param next  goes on to the first container noted that begins there or
  /// behind: what is asked for from left to right is found in one walk
  std::size_t findEnd(std::size_t begin, Containers::const_iterator& next) const;
  Containers::const_iterator findContainer(std::size_t begin) const;
  bool hasOddNumber(JsonSpan value) const;
  template <typename Put>
  void copyTo(JsonSpan value, const Put& put) const;

  std::unique_ptr<char[]> buffer_;  ///< not a string, which would be filled before it is read into
  std::string_view text_;           ///< of it, without the zero behind
  JsonSpan root_;
  Containers containers_;      ///< the outer levels of objects and arrays, by begin
  std::vector<JsonSpan> odd_;  ///< odd numbers, by begin
};

}  // namespace tsg::scene_graph
