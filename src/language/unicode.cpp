// SPDX-License-Identifier: BSD-3-Clause
#include "unicode.h"

#include <unicode/normalizer2.h>
#include <unicode/ustring.h>

#include <array>
#include <stdexcept>

namespace tsg::language {
namespace {

void checkStatus(UErrorCode status, const std::string& what) {
  if (U_FAILURE(status)) throw std::logic_error(what + ": ICU says " + u_errorName(status));
}

icu::UnicodeString normalizeWith(const icu::Normalizer2* normalizer, UErrorCode status,
                                 const icu::UnicodeString& text) {
  checkStatus(status, "Unicode normalisation data");
  const icu::UnicodeString result = normalizer->normalize(text, status);
  checkStatus(status, "Unicode normalisation");
  return result;
}

}  // namespace

icu::UnicodeString toUnicode(const std::string& utf8_text) {
  icu::UnicodeString text;
  // A text has at most as many UTF-16 units as it has bytes.
  const auto capacity = static_cast<std::int32_t>(utf8_text.size());
  std::int32_t length = 0;
  UErrorCode status = U_ZERO_ERROR;
  u_strFromUTF8(text.getBuffer(capacity), capacity, &length, utf8_text.data(), capacity, &status);
  text.releaseBuffer(U_SUCCESS(status) ? length : 0);
  if (U_FAILURE(status)) {
    throw std::invalid_argument("text of " + std::to_string(utf8_text.size()) +
                                " bytes is not valid UTF-8");
  }
  return text;
}

std::string toUtf8(const icu::UnicodeString& text) {
  std::string result;
  return text.toUTF8String(result);
}

icu::RegexPattern compilePattern(const char* pattern) {
  UErrorCode status = U_ZERO_ERROR;
  UParseError where;
  const std::unique_ptr<icu::RegexPattern> compiled(
      icu::RegexPattern::compile(icu::UnicodeString::fromUTF8(pattern), where, status));
  checkStatus(status, std::string("pattern '") + pattern + "'");
  return *compiled;
}

icu::UnicodeString replaceAll(const icu::RegexPattern& pattern, const icu::UnicodeString& text,
                              const icu::UnicodeString& replacement) {
  UErrorCode status = U_ZERO_ERROR;
  const std::unique_ptr<icu::RegexMatcher> matcher(pattern.matcher(text, status));
  checkStatus(status, "matching a pattern");
  const icu::UnicodeString result = matcher->replaceAll(replacement, status);
  checkStatus(status, "replacing a pattern");
  return result;
}

icu::UnicodeString normalizeNfc(const icu::UnicodeString& text) {
  UErrorCode status = U_ZERO_ERROR;
  const icu::Normalizer2* const normalizer = icu::Normalizer2::getNFCInstance(status);
  return normalizeWith(normalizer, status, text);
}

icu::UnicodeString normalizeNfkc(const icu::UnicodeString& text) {
  UErrorCode status = U_ZERO_ERROR;
  const icu::Normalizer2* const normalizer = icu::Normalizer2::getNFKCInstance(status);
  return normalizeWith(normalizer, status, text);
}

UChar32 decodeWindows1252(UChar32 byte) {
  constexpr std::array<UChar32, 32> kMeanings = {
      0x20ac, 0x81,   0x201a, 0x192,  0x201e, 0x2026, 0x2020, 0x2021, 0x2c6,  0x2030, 0x160,
      0x2039, 0x152,  0x8d,   0x17d,  0x8f,   0x90,   0x2018, 0x2019, 0x201c, 0x201d, 0x2022,
      0x2013, 0x2014, 0x2dc,  0x2122, 0x161,  0x203a, 0x153,  0x9d,   0x17e,  0x178};
  if (byte < 0x80 || byte > 0x9f) return byte;
  return kMeanings[static_cast<std::size_t>(byte - 0x80)];
}

}  // namespace tsg::language
