// SPDX-License-Identifier: BSD-3-Clause
#include "json_checker.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

namespace tsg::scene_graph {
namespace {

bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isHexDigit(char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0; }

bool isWordCharacter(char c) {
  return isDigit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '+' || c == '-' ||
         c == '.';
}

/// Whether a word is how some program writes a number that JSON does not have.
bool isOddNumber(std::string word) {
  if (isDigit(word.back())) return !std::isfinite(std::strtod(word.c_str(), nullptr));
  if (word[0] == '-' || word[0] == '+') word.erase(0, 1);
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return word == "nan" || word == "infinity" || word == "inf";
}

/// Bytes of the UTF-8 sequence that begins with a byte above 127; 0 if none does.
std::size_t countUtf8Bytes(unsigned char lead) {
  if (lead >= 0xC2 && lead <= 0xDF) return 2;
  if (lead >= 0xE0 && lead <= 0xEF) return 3;
  return lead >= 0xF0 && lead <= 0xF4 ? 4 : 0;
}

/// Range of the second byte: no overlong forms, no surrogates, nothing above U+10FFFF.
bool isSecondByte(unsigned char lead, unsigned char second) {
  const unsigned char low = lead == 0xE0 ? 0xA0 : lead == 0xF0 ? 0x90 : 0x80;
  const unsigned char high = lead == 0xED ? 0x9F : lead == 0xF4 ? 0x8F : 0xBF;
  return second >= low && second <= high;
}

bool isHighSurrogate(int code) { return code >= 0xD800 && code <= 0xDBFF; }
bool isLowSurrogate(int code) { return code >= 0xDC00 && code <= 0xDFFF; }

}  // namespace

void JsonChecker::fail(const std::string& what) const {
  const std::string_view before = text_.substr(0, at_);
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t line_end = before.rfind('\n');  // of the line before
  const std::size_t column = line_end == std::string_view::npos ? at_ + 1 : at_ - line_end;
  throw std::runtime_error("line " + std::to_string(line) + ", column " + std::to_string(column) +
                           ": " + (at_ >= text_.size() ? "the file ends; " : "") + what);
}

void JsonChecker::check() {
  if (text_.compare(0, 3, "\xEF\xBB\xBF") == 0) at_ = 3;  // byte order mark
  skipSpace();
  json_.root_.begin = at_;
  while (depth_ > 0 || is_value_next_) {
    skipSpace();
    if (is_value_next_) {
      checkValue();
    } else {
      checkSeparator();
    }
  }
  json_.root_.end = at_;
  skipSpace();
  if (at_ < text_.size()) fail("expected nothing behind the value");
}

void JsonChecker::skipSpace() {
  while (at_ < text_.size() &&
         (text_[at_] == ' ' || text_[at_] == '\n' || text_[at_] == '\r' || text_[at_] == '\t')) {
    ++at_;
  }
}

void JsonChecker::checkValue() {
  is_value_next_ = false;
  switch (peek()) {
    case '{':
      return open('}');
    case '[':
      return open(']');
    case '"':
      return checkString();
    default:
      return checkWord();
  }
}

void JsonChecker::open(char closing) {
  if (depth_ == kMaxDepth) {
    throw std::length_error("is nested deeper than " + std::to_string(kMaxDepth) +
                            " levels; expected a spark_dsg scene graph");
  }
  levels_[depth_] = {closing, json_.containers_.size()};
  if (depth_ < kNotedDepth) json_.containers_.push_back({at_, at_});
  ++depth_;
  ++at_;
  skipSpace();
  if (peek() == closing) return close();
  if (closing == '}') checkKey();
  is_value_next_ = true;
}

void JsonChecker::close() {
  ++at_;
  --depth_;
  if (depth_ < kNotedDepth) json_.containers_[levels_[depth_].container].end = at_;
}

void JsonChecker::checkSeparator() {
  const char closing = levels_[depth_ - 1].closing;
  if (peek() == closing) return close();
  if (peek() != ',') fail(std::string("expected ',' or '") + closing + "'");
  ++at_;
  skipSpace();
  if (closing == '}') checkKey();
  is_value_next_ = true;
}

void JsonChecker::checkKey() {
  if (peek() != '"') fail("expected the name of a field in quotes");
  checkString();
  skipSpace();
  if (peek() != ':') fail("expected ':'");
  ++at_;
}

void JsonChecker::checkString() {
  for (++at_; at_ < text_.size(); ++at_) {
    const auto c = static_cast<unsigned char>(text_[at_]);
    if (c == '"') {
      ++at_;
      return;
    }
    if (c < 0x20) fail("a control character in a string, expected an escape");
    if (c == '\\') checkEscape();
    if (c >= 0x80) checkUtf8();
  }
  fail("expected the end of a string");
}

// Ends at the last character of the escape, as checkUtf8 at the last byte of the sequence.
void JsonChecker::checkEscape() {
  const auto readCode = [this] {
    for (std::size_t i = 1; i <= 4; ++i) {
      if (at_ + i >= text_.size() || !isHexDigit(text_[at_ + i])) fail("expected 4 hex digits");
    }
    const int code = std::stoi(std::string(text_.substr(at_ + 1, 4)), nullptr, 16);
    at_ += 4;
    return code;
  };
  ++at_;
  if (std::string("\"\\/bfnrt").find(peek()) != std::string::npos) return;
  if (peek() != 'u') fail("an unknown escape in a string");
  const int code = readCode();
  if (isLowSurrogate(code)) fail("half a surrogate pair");
  if (!isHighSurrogate(code)) return;
  if (text_.compare(at_ + 1, 2, "\\u") != 0) fail("half a surrogate pair");
  at_ += 2;
  if (!isLowSurrogate(readCode())) fail("half a surrogate pair");
}

void JsonChecker::checkUtf8() {
  const auto lead = static_cast<unsigned char>(text_[at_]);
  const std::size_t count = countUtf8Bytes(lead);
  bool is_valid = count > 0 && at_ + count <= text_.size();
  for (std::size_t i = 1; is_valid && i < count; ++i) {
    const auto byte = static_cast<unsigned char>(text_[at_ + i]);
    is_valid = i == 1 ? isSecondByte(lead, byte) : byte >= 0x80 && byte <= 0xBF;
  }
  if (!is_valid) fail("a string is not valid UTF-8");
  at_ += count - 1;
}

// False if there is no number of JSON's grammar here; ends behind what was read of it.
bool JsonChecker::skipNumber() {
  const auto skipDigits = [this] {
    const std::size_t begin = at_;
    while (isDigit(peek())) ++at_;
    return at_ - begin;
  };
  if (peek() == '-') ++at_;
  const bool is_zero = peek() == '0';
  const std::size_t num_digits = skipDigits();
  if (num_digits == 0 || (is_zero && num_digits > 1)) return false;
  if (peek() == '.') {
    ++at_;
    if (skipDigits() == 0) return false;
  }
  num_exponent_digits_ = 0;
  if (peek() != 'e' && peek() != 'E') return true;
  ++at_;
  if (peek() == '+' || peek() == '-') ++at_;
  num_exponent_digits_ = skipDigits();
  return num_exponent_digits_ > 0;
}

// A number that a double surely holds; else nothing is skipped.
bool JsonChecker::skipPlainNumber() {
  constexpr std::size_t kLongNumber = 200;  // digits, and 99 more by an exponent: a double holds it
  const std::size_t begin = at_;
  const bool is_plain = skipNumber() && !isWordCharacter(peek()) && num_exponent_digits_ <= 2 &&
                        at_ - begin <= kLongNumber;
  if (!is_plain) at_ = begin;
  return is_plain;
}

// Most of a file are lists of numbers: they are walked through here.
void JsonChecker::checkWord() {
  if (!skipPlainNumber()) return checkOddWord();
  const bool is_in_list = depth_ > 0 && levels_[depth_ - 1].closing == ']';
  while (is_in_list && peek() == ',') {
    ++at_;
    is_value_next_ = !skipPlainNumber();
    if (is_value_next_) return;
  }
}

void JsonChecker::checkOddWord() {
  const std::size_t begin = at_;
  const bool is_number = skipNumber() && !isWordCharacter(peek());
  while (isWordCharacter(peek())) ++at_;
  const std::string word(text_.substr(begin, at_ - begin));
  if (word == "true" || word == "false" || word == "null") return;
  if (!word.empty() && isOddNumber(word)) {
    json_.odd_.push_back({begin, at_});
  } else if (!is_number) {
    at_ = begin;
    fail("expected a value" + (word.empty() ? "" : ", found '" + word.substr(0, 40) + "'"));
  }
}

}  // namespace tsg::scene_graph
