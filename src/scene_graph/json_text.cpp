// SPDX-License-Identifier: BSD-3-Clause
#include "json_text.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "json_checker.h"
#include "json_numbers.h"
#include "task_scene_graph/core/file_kind.h"

namespace tsg::scene_graph {
namespace {

std::unique_ptr<char[]> copyText(const std::string& text) {
  std::unique_ptr<char[]> buffer(new char[text.size() + 1]);
  std::copy(text.begin(), text.end(), buffer.get());
  return buffer;
}

/// Whether an object or list is not closed at the end.
bool isCutOff(std::string_view text) {
  const char first = text[text.find_first_not_of(" \t\r\n")];
  const char last = text[text.find_last_not_of(" \t\r\n")];
  return (first == '{' && last != '}') || (first == '[' && last != ']');
}

bool isBefore(JsonSpan span, std::size_t at) { return span.begin < at; }

std::string decodeString(const std::string& quoted) {
  if (quoted.find('\\') == std::string::npos) return quoted.substr(1, quoted.size() - 2);
  return nlohmann::json::parse(quoted).get<std::string>();
}

bool isDigit(char c) { return c >= '0' && c <= '9'; }

/// What strtoull() or strtoll() makes of a value that begins with a digit or a sign; nothing unless
/// that is all of it and in range.
template <typename Integer>
std::optional<Integer> readWhole(std::string_view text, JsonSpan value,
                                 Integer (*parse)(const char*, char**, int)) {
  char* end = nullptr;
  errno = 0;
  const Integer number = parse(text.data() + value.begin, &end, 10);
  if (errno != 0 || end != text.data() + value.end) return std::nullopt;
  return number;
}

}  // namespace

std::size_t JsonObject::findIndex(std::string_view key) const {
  if (!index_.empty()) {
    const auto place = index_.find(key);
    return place == index_.end() ? fields_.size() : place->second;
  }
  std::size_t i = 0;
  while (i < fields_.size() && fields_[i].key != key) ++i;
  return i;
}

void JsonObject::add(std::string key, JsonSpan value) {
  constexpr std::size_t kMany = 64;  // from here on, looking through all of them does not pay
  const std::size_t i = findIndex(key);
  if (i < fields_.size()) {
    fields_[i].value = value;
    return;
  }
  fields_.push_back({std::move(key), value});
  if (fields_.size() < kMany) return;
  for (std::size_t k = index_.size(); k < fields_.size(); ++k) index_.emplace(fields_[k].key, k);
}

const JsonSpan* JsonObject::find(std::string_view key) const& {
  const std::size_t i = findIndex(key);
  return i < fields_.size() ? &fields_[i].value : nullptr;
}

JsonText JsonText::read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(std::string("cannot be opened: ") + std::strerror(errno));
  const std::string kind = describeFileKind(path);
  if (!kind.empty()) throw std::runtime_error(kind);
  const auto size = static_cast<std::size_t>(std::filesystem::file_size(path));
  std::unique_ptr<char[]> buffer(new char[size + 1]);
  in.read(buffer.get(), static_cast<std::streamsize>(size));
  return JsonText(std::move(buffer), static_cast<std::size_t>(in.gcount()));
}

JsonText::JsonText(const std::string& text) : JsonText(copyText(text), text.size()) {}

JsonText::JsonText(std::unique_ptr<char[]> buffer, std::size_t size)
    : buffer_(std::move(buffer)), text_(buffer_.get(), size) {
  buffer_[size] = '\0';
  if (text_.find_first_not_of(" \t\r\n") == std::string::npos) {
    throw std::runtime_error("holds nothing but spaces");
  }
  try {
    JsonChecker(*this).check();
  } catch (const std::runtime_error& e) {
    throw std::runtime_error("is not JSON" + std::string(isCutOff(text_) ? " or cut off" : "") +
                             ": " + e.what());
  }
}

std::size_t JsonText::skipSpace(std::size_t at) const {
  while (text_[at] == ' ' || text_[at] == '\n' || text_[at] == '\r' || text_[at] == '\t') ++at;
  return at;
}

std::size_t JsonText::skipString(std::size_t at) const {
  for (++at; text_[at] != '"'; ++at) {
    if (text_[at] == '\\') ++at;
  }
  return at + 1;
}

JsonText::Containers::const_iterator JsonText::findContainer(std::size_t begin) const {
  return std::lower_bound(containers_.begin(), containers_.end(), begin, isBefore);
}

std::size_t JsonText::findEnd(std::size_t begin, Containers::const_iterator& next) const {
  if (text_[begin] == '"') return skipString(begin);
  if (text_[begin] != '{' && text_[begin] != '[') return text_.find_first_of(",]} \t\r\n", begin);
  while (next != containers_.end() && next->begin < begin) ++next;
  if (next != containers_.end() && next->begin == begin) return next->end;
  int depth = 0;
  for (std::size_t at = begin;;) {
    const char c = text_[at];
    if (c == '"') {
      at = skipString(at);
      continue;
    }
    ++at;
    if (c == '{' || c == '[') ++depth;
    if ((c == '}' || c == ']') && --depth == 0) return at;
  }
}

JsonObject JsonText::readObject(JsonSpan value) const {
  JsonObject object;
  if (!isObject(value)) return object;
  auto next = findContainer(value.begin);
  std::size_t at = skipSpace(value.begin + 1);
  while (text_[at] != '}') {
    const std::size_t key_end = skipString(at);
    std::string key = decodeString(std::string(text_.substr(at, key_end - at)));
    const std::size_t begin = skipSpace(skipSpace(key_end) + 1);
    const JsonSpan span{begin, findEnd(begin, next)};
    object.add(std::move(key), span);
    at = skipSpace(span.end);
    if (text_[at] == ',') at = skipSpace(at + 1);
  }
  return object;
}

std::vector<JsonSpan> JsonText::readArray(JsonSpan value) const {
  std::vector<JsonSpan> elements;
  if (!isArray(value)) return elements;
  auto next = findContainer(value.begin);
  std::size_t at = skipSpace(value.begin + 1);
  while (text_[at] != ']') {
    elements.push_back({at, findEnd(at, next)});
    at = skipSpace(elements.back().end);
    if (text_[at] == ',') at = skipSpace(at + 1);
  }
  return elements;
}

std::optional<std::uint64_t> JsonText::readUnsigned(JsonSpan value) const {
  if (!isDigit(text_[value.begin])) return std::nullopt;
  return readWhole<unsigned long long>(text_, value, std::strtoull);
}

std::optional<std::int64_t> JsonText::readInteger(JsonSpan value) const {
  if (!isDigit(text_[value.begin]) && text_[value.begin] != '-') return std::nullopt;
  return readWhole<long long>(text_, value, std::strtoll);
}

bool JsonText::isNull(JsonSpan value) const {
  const auto odd = std::lower_bound(odd_.begin(), odd_.end(), value.begin, isBefore);
  return text_.substr(value.begin, value.size()) == "null" ||
         (odd != odd_.end() && odd->begin == value.begin);
}

std::optional<double> JsonText::readNumber(JsonSpan value) const {
  const bool is_number = isDigit(text_[value.begin]) || text_[value.begin] == '-';
  if (!is_number || hasOddNumber(value)) return std::nullopt;
  return std::strtod(text_.data() + value.begin, nullptr);
}

std::optional<Embedding> JsonText::readFloats(JsonSpan value) const {
  if (!isArray(value) || hasOddNumber(value)) return std::nullopt;
  const auto commas = std::count(text_.begin() + static_cast<std::ptrdiff_t>(value.begin),
                                 text_.begin() + static_cast<std::ptrdiff_t>(value.end), ',');
  Embedding numbers(commas + 1);
  Eigen::Index count = 0;
  for (std::size_t at = skipSpace(value.begin + 1); text_[at] != ']';) {
    const char* begin = text_.data() + at;
    const char* end = parseNumber(begin, numbers[count]);
    if (end == begin) return std::nullopt;
    ++count;
    at = skipSpace(at + static_cast<std::size_t>(end - begin));
    if (text_[at] == ',') at = skipSpace(at + 1);
  }
  numbers.conservativeResize(count);
  return numbers;
}

bool JsonText::hasOddNumber(JsonSpan value) const {
  const auto first = std::lower_bound(odd_.begin(), odd_.end(), value.begin, isBefore);
  return first != odd_.end() && first->begin < value.end;
}

template <typename Put>
void JsonText::copyTo(JsonSpan value, const Put& put) const {
  std::size_t at = value.begin;
  auto odd = std::lower_bound(odd_.begin(), odd_.end(), value.begin, isBefore);
  for (; odd != odd_.end() && odd->begin < value.end; ++odd) {
    put(text_.data() + at, odd->begin - at);
    put("null", 4);
    at = odd->end;
  }
  put(text_.data() + at, value.end - at);
}

std::string JsonText::copy(JsonSpan value) const {
  std::string copied;
  copied.reserve(value.size());
  copyTo(value, [&](const char* begin, std::size_t size) { copied.append(begin, size); });
  return copied;
}

void JsonText::write(JsonSpan value, std::ostream& out) const {
  copyTo(value, [&](const char* begin, std::size_t size) {
    out.write(begin, static_cast<std::streamsize>(size));
  });
}

}  // namespace tsg::scene_graph
