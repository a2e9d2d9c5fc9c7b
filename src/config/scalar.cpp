// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/config/scalar.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <locale>
#include <regex>
#include <sstream>

namespace tsg::config {
namespace {

/// Without the underscores that YAML 1.1 allows between digits.
std::string removeUnderscores(std::string text) {
  text.erase(std::remove(text.begin(), text.end(), '_'), text.end());
  return text;
}

double parseWithBase(const std::string& digits, double base) {
  double value = 0.0;
  for (const char c : digits) value = value * base + std::stoi(std::string(1, c), nullptr, 16);
  return value;
}

/// The same in every locale, which strtod is not; nothing for what is too large.
std::optional<double> parseDecimal(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double value = 0.0;
  stream >> value;
  return stream.fail() ? std::nullopt : std::optional<double>(value);
}

bool isOneOf(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* word) { return text == word; });
}

std::optional<double> parseSpecial(const std::string& text) {
  const double infinity = std::numeric_limits<double>::infinity();
  if (isOneOf(text, {".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"})) return infinity;
  if (isOneOf(text, {"-.inf", "-.Inf", "-.INF"})) return -infinity;
  if (isOneOf(text, {".nan", ".NaN", ".NAN"})) return std::numeric_limits<double>::quiet_NaN();
  return std::nullopt;
}

/// A NUL would end the text of an exception.
std::string escapeControls(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (static_cast<unsigned char>(c) >= 0x20) {
      escaped += c;
      continue;
    }
    std::array<char, 8> code{};
    std::snprintf(code.data(), code.size(), "\\x%02x", static_cast<unsigned>(c));
    escaped += code.data();
  }
  return escaped;
}

bool isLeadingZero(const std::string& text) {
  static const std::regex pattern(R"([-+]?0[0-9_]+)");
  return std::regex_match(text, pattern);
}

}  // namespace

std::optional<double> parseNumber(const std::string& text) {
  static const std::regex based(R"(([-+]?)0(x[0-9a-fA-F_]+|b[01_]+))");
  static const std::regex decimal(
      R"([-+]?([0-9][0-9_]*(\.[0-9_]*)?|\.[0-9][0-9_]*)([eE][-+]?[0-9]+)?)");
  if (const auto special = parseSpecial(text)) return special;
  if (isLeadingZero(text)) return std::nullopt;
  std::smatch match;
  if (std::regex_match(text, match, based)) {
    const std::string digits = removeUnderscores(match[2].str().substr(1));
    if (digits.empty()) return std::nullopt;
    const double value = parseWithBase(digits, match[2].str()[0] == 'x' ? 16.0 : 2.0);
    return match[1] == "-" ? -value : value;
  }
  if (!std::regex_match(text, decimal)) return std::nullopt;
  return parseDecimal(removeUnderscores(text));
}

std::optional<int> parseInteger(const std::string& text) {
  const auto value = parseNumber(text);
  if (!value || std::floor(*value) != *value) return std::nullopt;  // NaN differs from itself
  if (*value < std::numeric_limits<int>::min() || *value > std::numeric_limits<int>::max()) {
    return std::nullopt;
  }
  return static_cast<int>(*value);
}

std::optional<std::vector<double>> parseNumbers(std::string text) {
  for (char& c : text) {
    if (c == ',' || c == '[' || c == ']' || c == ';') c = ' ';
  }
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (std::string word; stream >> word;) {
    char* end = nullptr;
    numbers.push_back(std::strtod(word.c_str(), &end));
    if (end != word.c_str() + word.size()) return std::nullopt;
  }
  return numbers;
}

std::optional<bool> parseBool(const std::string& text) {
  if (isOneOf(text, {"true", "True", "TRUE", "yes", "Yes", "YES", "on", "On", "ON", "y", "Y"})) {
    return true;
  }
  if (isOneOf(text, {"false", "False", "FALSE", "no", "No", "NO", "off", "Off", "OFF", "n", "N"})) {
    return false;
  }
  return std::nullopt;
}

std::string formatExactly(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
  std::string text;
  for (int digits = 6; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    std::ostringstream stream;
    stream.imbue(std::locale::classic());
    stream.precision(digits);
    stream << value;
    text = stream.str();
    if (parseDecimal(text) == value) break;
  }
  // YAML 1.1 takes 1e-05 for a string.
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) {
    text.insert(exponent, ".0");
  }
  return text;
}

std::string explainNumber(const std::string& text) {
  if (isLeadingZero(text)) {
    return ": with a leading 0 it is octal to some readers and decimal to others; write it without";
  }
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos) return "";
  std::string pointed = text;
  pointed[comma] = '.';
  return parseNumber(pointed) ? ": decimals are written with a point, " + pointed : "";
}

std::string quoteYaml(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return escapeControls(quoted) + '"';
}

std::string formatNode(const YAML::Node& node) {
  if (node.IsScalar()) return escapeControls(node.Scalar());
  if (!node.IsSequence() && !node.IsMap()) return "";
  std::string items;
  for (const auto& item : node) {
    items += items.empty() ? "" : ", ";
    items +=
        node.IsMap() ? formatNode(item.first) + ": " + formatNode(item.second) : formatNode(item);
  }
  return node.IsMap() ? "{" + items + "}" : "[" + items + "]";
}

std::string describeTyped(const YAML::Node& scalar) {
  const std::string& tag = scalar.Tag();
  if (tag == kBoolTag) return "the boolean " + scalar.Scalar();
  if (tag == kIntTag || tag == kFloatTag) return "the number " + scalar.Scalar();
  return "";
}

}  // namespace tsg::config
