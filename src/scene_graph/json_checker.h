// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "json_text.h"

namespace tsg::scene_graph {

/// Walks through a JSON text once [RFC 8259]: checks it, and notes where the containers of its
/// outer levels and its odd numbers are.
class JsonChecker {
 public:
  explicit JsonChecker(JsonText& json) : json_(json), text_(json.text_) {}

  /// @throws std::runtime_error saying where the text is no JSON and why.
  void check();

 private:
  void checkValue();
  void open(char closing);
  void close();
  void checkSeparator();
  void checkKey();
  void checkString();
  void checkEscape();
  void checkUtf8();
  void checkWord();
  void checkOddWord();
  bool skipNumber();
  bool skipPlainNumber();
  void skipSpace();
  /// Zero at the end.
  char peek() const { return text_.data()[at_]; }
  [[noreturn]] void fail(const std::string& what) const;

  static constexpr std::size_t kMaxDepth = 256;
  /// A graph, its nodes, a node, its attributes, a mesh or an embedding, their lists of numbers.
  static constexpr std::size_t kNotedDepth = 6;

  struct Level {
    char closing = ']';
    std::size_t container = 0;  ///< where it is noted
  };

  JsonText& json_;
  const std::string_view text_;  ///< a zero is behind it
  std::size_t at_ = 0;
  std::array<Level, kMaxDepth> levels_;
  std::size_t depth_ = 0;
  std::size_t num_exponent_digits_ = 0;  ///< of the number read last
  bool is_value_next_ = true;            ///< else a separator or an end
};

}  // namespace tsg::scene_graph
