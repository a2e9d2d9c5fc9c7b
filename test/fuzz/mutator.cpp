// SPDX-License-Identifier: BSD-3-Clause
#include "mutator.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <iterator>
#include <limits>
#include <sstream>
#include <utility>

namespace tsg::fuzz {
namespace {

using nlohmann::json;

const std::vector<std::string>& listNumbers() {
  static const std::vector<std::string> numbers{"0",
                                                "-0",
                                                "1",
                                                "-1",
                                                "-2",
                                                "0.5",
                                                "1e-5",
                                                "1e5",
                                                "1e308",
                                                "-1e308",
                                                "1e999",
                                                "-1e999",
                                                "1e-320",
                                                "nan",
                                                "NaN",
                                                ".nan",
                                                "inf",
                                                ".inf",
                                                "-.inf",
                                                "Infinity",
                                                "2147483647",
                                                "2147483648",
                                                "-2147483649",
                                                "4294967295",
                                                "4294967296",
                                                "9223372036854775807",
                                                "9223372036854775808",
                                                "18446744073709551615",
                                                "18446744073709551616",
                                                "999999999999999999999999999999999999",
                                                "0x7fffffff",
                                                "0b11",
                                                "0777",
                                                "1_000",
                                                "1,5",
                                                "1e",
                                                "--1",
                                                "+1"};
  return numbers;
}

/// What YAML readers take for something else than a word.
const std::vector<std::string>& listYamlValues() {
  static const std::vector<std::string> values{
      "",          "~",           "''",        "\"\"",
      "true",      "[]",          "{}",        "[1, 2, 3]",
      "[1, [2]",   "[[[[1]]]]",   "{a: b}",    "{a: {b: c}",
      "&a 1",      "*a",          "&a [*a]",   "&a {b: *a}",
      "!!int x",   "!!binary =",  "|",         ">-",
      "@x",        "%x",          "`",         "'x",
      "\"\\xff\"", "\"\\u0000\"", "\xc3\x28",  "\xef\xbb\xbf",
      "- - - x",   "? x",         "${HOME}",   "$NO_SUCH",
      "~nobody/x", "/",           "/dev/null", "..",
      "file:///x", "http://x"};
  return values;
}

const std::vector<json>& listJsonValues() {
  static const std::vector<json> values{json(),
                                        json(true),
                                        json(0),
                                        json(1),
                                        json(2),
                                        json(-1),
                                        json(-2),
                                        json(1.5),
                                        json(1e308),
                                        json(-1e308),
                                        json(4294967296),
                                        json(std::numeric_limits<std::uint64_t>::max()),
                                        json(std::numeric_limits<std::int64_t>::min()),
                                        json(""),
                                        json("AABB"),
                                        json("OBB"),
                                        json("\xf0\x9f\xa4\x96"),
                                        json::array(),
                                        json::object(),
                                        json({1, 2}),
                                        json({1, 2, 3}),
                                        json({1, 2, "3"}),
                                        json({json({1, 2, 3})}),
                                        json({{"w", 0}, {"x", 0}, {"y", 0}, {"z", 0}}),
                                        json({{"rows", -2}, {"cols", -2}, {"data", {1, 2, 3, 4}}}),
                                        json({{"points", {1, 2}}})};
  return values;
}

std::vector<std::string> splitLines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace

const std::string& Mutator::pickNumber() { return pickFrom(listNumbers()); }

double Mutator::pickDouble() {
  using Limits = std::numeric_limits<double>;
  static const std::vector<double> values{0.0,
                                          -0.0,
                                          1.0,
                                          -1.0,
                                          0.5,
                                          1e-12,
                                          1e-320,
                                          255.0,
                                          1e6,
                                          2147483648.0,
                                          4294967296.0,
                                          1e19,
                                          1e39,
                                          Limits::max(),
                                          Limits::lowest(),
                                          Limits::infinity(),
                                          -Limits::infinity(),
                                          Limits::quiet_NaN()};
  return pickFrom(values);
}

std::uint64_t Mutator::pickInteger() {
  static const std::vector<std::uint64_t> values{0,
                                                 1,
                                                 2,
                                                 3,
                                                 7,
                                                 8,
                                                 127,
                                                 128,
                                                 255,
                                                 256,
                                                 32767,
                                                 32768,
                                                 65535,
                                                 65536,
                                                 1000000007,
                                                 2147483647,
                                                 2147483648,
                                                 4294967295,
                                                 4294967296,
                                                 9223372036854775807U,
                                                 9223372036854775808U,
                                                 18446744073709551615U};
  return pickFrom(values);
}

void Mutator::nest(std::string& text) {
  static const std::vector<std::string> openers{"[", "{", "- ", "{\"a\":", "[["};
  const std::string& opener = pickFrom(openers);
  const std::size_t count = isOneIn(20) ? 100'000 : pickFrom(std::vector<std::size_t>{3, 70, 300});
  std::string nested;
  for (std::size_t i = 0; i < count; ++i) nested += opener;
  text.insert(pick(text.size() + 1), nested);
}

void Mutator::replaceNumber(std::string& text) {
  const auto isDigit = [](unsigned char c) { return std::isdigit(c) != 0; };
  const auto begin = std::find_if(text.begin() + static_cast<std::ptrdiff_t>(pick(text.size())),
                                  text.end(), isDigit);
  const auto end = std::find_if_not(begin, text.end(), isDigit);
  text.replace(begin, end, pickNumber());
}

void Mutator::overwriteNumber(std::string& bytes) {
  std::uint64_t value = pickInteger();
  if (isOneIn(3)) {
    const double number = pickDouble();
    std::memcpy(&value, &number, sizeof(value));
  } else if (isOneIn(3)) {
    const auto number = static_cast<float>(std::clamp(pickDouble(), -3e38, 3e38));
    std::memcpy(&value, &number, sizeof(number));
  }
  const std::size_t size = std::min<std::size_t>(bytes.size(), isOneIn(2) ? 4 : 8);
  std::memcpy(bytes.data() + pick(bytes.size() - size + 1), &value, size);
}

void Mutator::mutateOnce(const std::vector<std::string>& words, std::string& text) {
  const std::size_t at = pick(text.size());
  const std::size_t length = 1 + pick(std::min<std::size_t>(text.size() - at, 40));
  switch (pick(11)) {
    case 0:
      text[at] = static_cast<char>(pick(256));
      break;
    case 1:
      text[at] = static_cast<char>(text[at] ^ (1 << pick(8)));
      break;
    case 2:
      text.erase(at, length);
      break;
    case 3:
      text.insert(at, text.substr(pick(text.size()), length));
      break;
    case 4:
      text.resize(at);
      break;
    case 5:
      text.insert(at, pickNumber());
      break;
    case 6:
    case 7:
      if (!words.empty()) text.insert(at, pickFrom(words));
      break;
    case 8:
      replaceNumber(text);
      break;
    case 9:
      overwriteNumber(text);
      break;
    default:
      if (isOneIn(8)) nest(text);
  }
}

void Mutator::mutateBytes(const std::vector<std::string>& words, std::string& text) {
  for (std::size_t i = 1 + pick(4); i > 0 && !text.empty(); --i) mutateOnce(words, text);
}

void Mutator::mutateLine(std::vector<std::string>& lines) {
  const std::size_t at = pick(lines.size());
  const auto place = lines.begin() + static_cast<std::ptrdiff_t>(at);
  const std::size_t colon = lines[at].find(':');
  switch (pick(7)) {
    case 0:
      lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(pick(lines.size())),
                   std::string(lines[at]));
      break;
    case 1:
      lines.erase(place);
      break;
    case 2:
      lines[at].insert(0, std::string(1 + pick(4), isOneIn(8) ? '\t' : ' '));
      break;
    case 3:
      if (colon != std::string::npos) lines[at].replace(0, colon, pickFrom(listYamlValues()));
      break;
    default:
      if (colon == std::string::npos) break;
      lines[at].erase(colon + 1);
      lines[at] += " " + (isOneIn(2) ? pickNumber() : pickFrom(listYamlValues()));
  }
}

void Mutator::mutateYaml(std::string& text) {
  std::vector<std::string> lines = splitLines(text);
  for (std::size_t i = 1 + pick(4); i > 0 && !lines.empty(); --i) mutateLine(lines);
  text.clear();
  for (const auto& line : lines) text += line + '\n';
}

void Mutator::mutateValue(json& root) {
  json* value = &root;
  while (value->is_structured() && !value->empty() && !isOneIn(6)) {
    value = &*std::next(value->begin(), static_cast<std::ptrdiff_t>(pick(value->size())));
  }
  if (!value->is_structured() || value->empty() || !isOneIn(3)) {
    *value = pickFrom(listJsonValues());
    return;
  }
  const auto child = std::next(value->begin(), static_cast<std::ptrdiff_t>(pick(value->size())));
  const json copy = *child;
  if (isOneIn(2)) {
    value->erase(child);
  } else if (value->is_array()) {
    value->push_back(copy);
  } else {
    const auto other = std::next(value->begin(), static_cast<std::ptrdiff_t>(pick(value->size())));
    *other = copy;
  }
}

void Mutator::mutateJson(json& root) {
  for (std::size_t i = 1 + pick(4); i > 0; --i) mutateValue(root);
}

std::string makeJson(Mutator& mutator, json root) {
  static const std::vector<std::string> words{"NaN", "-Infinity", "[",    "]",      "{",       "}",
                                              "\"",  ",",         ":",    "null",   "\\ud800", "\\",
                                              "\n",  "\xff",      "/**/", "\"id\":"};
  const bool is_text = mutator.isOneIn(3);
  if (!is_text) mutator.mutateJson(root);
  std::string text = root.dump();
  if (is_text) mutator.mutateBytes(words, text);
  return text;
}

std::string makeYaml(Mutator& mutator, std::string text) {
  static const std::vector<std::string> words{
      "&a ", "*a",  "<<: ", "!!str ", "---\n", "...\n", "? ",   ": ",
      "- ",  "|\n", ">\n",  "\t",     "[",     "]",     "{",    "}",
      "\"",  "'",   "#",    "%",      "\xff",  ", ",    "\r\n", "\xef\xbb\xbf"};
  if (mutator.isOneIn(3)) {
    mutator.mutateBytes(words, text);
  } else {
    mutator.mutateYaml(text);
  }
  return text;
}

}  // namespace tsg::fuzz
