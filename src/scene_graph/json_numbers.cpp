// SPDX-License-Identifier: BSD-3-Clause
#include "json_numbers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

namespace tsg::scene_graph {
namespace {

/// A number without its sign: digits * 10^exponent; further digits are left out.
struct Decimal {
  std::uint64_t digits = 0;
  int num_digits = 0;
  int exponent = 0;
};

constexpr int kMostDigits = 19;  // of a 64-bit number

bool isDigit(char c) { return c >= '0' && c <= '9'; }

void addDigit(char digit, bool is_fraction, Decimal& decimal) {
  if (decimal.num_digits == kMostDigits) {
    decimal.exponent += is_fraction ? 0 : 1;
    return;
  }
  decimal.digits = 10 * decimal.digits + static_cast<std::uint64_t>(digit - '0');
  decimal.num_digits += decimal.digits != 0 ? 1 : 0;
  decimal.exponent -= is_fraction ? 1 : 0;
}

const char* parseExponent(const char* at, int& exponent) {
  constexpr int kBeyondAllNumbers = 100'000;
  const bool is_negative = *at == '-';
  if (*at == '-' || *at == '+') ++at;
  int value = 0;
  for (; isDigit(*at); ++at) value = std::min(10 * value + (*at - '0'), kBeyondAllNumbers);
  exponent += is_negative ? -value : value;
  return at;
}

const char* parseDecimal(const char* at, Decimal& decimal) {
  for (; isDigit(*at); ++at) addDigit(*at, false, decimal);
  if (*at == '.') {
    for (++at; isDigit(*at); ++at) addDigit(*at, true, decimal);
  }
  if (*at == 'e' || *at == 'E') at = parseExponent(at + 1, decimal.exponent);
  return at;
}

/// Within two steps of the double that is nearest; only for exponents of -44 to 22.
double approximate(const Decimal& decimal) {
  static constexpr std::array<double, 23> kPowers = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                     1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                     1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  const auto digits = static_cast<double>(decimal.digits);
  if (decimal.exponent >= 0) return digits * kPowers[static_cast<std::size_t>(decimal.exponent)];
  const auto shift = static_cast<std::size_t>(-decimal.exponent);
  return shift <= 22 ? digits / kPowers[shift] : digits / kPowers[22] / kPowers[shift - 22];
}

/// Whether a double that is two steps off may round to another float than the right one.
bool isNearMiddleOfFloats(double value) {
  constexpr std::uint64_t kDropped = (std::uint64_t{1} << 29) - 1;  // bits that a float has not
  constexpr std::int64_t kMiddle = std::int64_t{1} << 28;
  constexpr std::int64_t kMargin = 8;
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  return std::abs(static_cast<std::int64_t>(bits & kDropped) - kMiddle) <= kMargin;
}

template <typename Number>
void append(Number value, std::string& text) {
  if (!std::isfinite(value)) {
    text += "null";
    return;
  }
  std::array<char, 64> buffer{};
  const char* end = nlohmann::detail::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  text.append(buffer.data(), static_cast<std::size_t>(end - buffer.data()));
}

}  // namespace

const char* parseNumber(const char* text, float& value) {
  constexpr double kSmallest = 1e-30;  // far from where floats get coarser
  constexpr double kLargest = 1e30;
  const bool is_negative = *text == '-';
  const char* begin = text + (is_negative ? 1 : 0);
  if (!isDigit(*begin)) return text;
  Decimal decimal;
  const char* end = parseDecimal(begin, decimal);
  double number = 0.0;
  const bool is_in_reach = decimal.exponent >= -44 && decimal.exponent <= 22;
  if (decimal.digits != 0 && is_in_reach) number = approximate(decimal);
  const bool is_sure = decimal.digits == 0 ||
                       (number > kSmallest && number < kLargest && !isNearMiddleOfFloats(number));
  if (!is_sure) number = std::strtod(begin, nullptr);
  if (!std::isfinite(number)) return text;
  value = static_cast<float>(is_negative ? -number : number);
  return end;
}

void appendNumber(float value, std::string& text) { append(value, text); }

void appendNumber(double value, std::string& text) { append(value, text); }

void appendNumbers(const Embedding& values, std::string& text) {
  text += '[';
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (i > 0) text += ',';
    append(values[i], text);
  }
  text += ']';
}

}  // namespace tsg::scene_graph
