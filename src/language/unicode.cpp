// SPDX-License-Identifier: BSD-3-Clause
#include "unicode.h"

#include <locale.h>

#include <clocale>
#include <cstdint>
#include <cwctype>
#include <stdexcept>

namespace tsg::language {
namespace {

/// Null if the system lacks it.
locale_t unicodeLocale() {
  static const locale_t locale = newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);
  return locale;
}

bool isAscii(char32_t c) { return c < 0x80; }
bool isIn(char32_t c, char32_t first, char32_t last) { return c >= first && c <= last; }

/// Bytes that follow a first byte; -1 for one that begins nothing.
int countFollowers(unsigned char first) {
  if (first < 0x80) return 0;
  if (isIn(first, 0xc2, 0xdf)) return 1;
  if (isIn(first, 0xe0, 0xef)) return 2;
  return isIn(first, 0xf0, 0xf4) ? 3 : -1;
}

/// False for surrogates, what fewer bytes would do for, and what lies beyond Unicode.
bool isProper(char32_t c, int followers) {
  if (followers == 2) return c >= 0x800 && !isIn(c, 0xd800, 0xdfff);
  return followers != 3 || isIn(c, 0x10000, 0x10ffff);
}

}  // namespace

std::u32string decodeUtf8(const std::string& text) {
  const auto fail = [&] {
    throw std::invalid_argument("text of " + std::to_string(text.size()) +
                                " bytes is not valid UTF-8");
  };
  std::u32string result;
  for (std::size_t at = 0; at < text.size();) {
    const auto first = static_cast<unsigned char>(text[at++]);
    const int followers = countFollowers(first);
    if (followers < 0) fail();
    char32_t c = followers == 0 ? first : first & (0x3fU >> followers);
    for (int i = 0; i < followers; ++i, ++at) {
      const auto byte = at < text.size() ? static_cast<unsigned char>(text[at]) : 0U;
      if ((byte & 0xc0U) != 0x80U) fail();
      c = (c << 6) | (byte & 0x3fU);
    }
    if (!isProper(c, followers)) fail();
    result += c;
  }
  return result;
}

std::string encodeUtf8(const std::u32string& text) {
  std::string result;
  for (const char32_t c : text) {
    const int followers = c < 0x80 ? 0 : c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
    const auto lead = followers == 0 ? 0U : 0xff00U >> (followers + 1);
    result += static_cast<char>((lead & 0xffU) | (c >> (6 * followers)));
    for (int i = followers - 1; i >= 0; --i) {
      result += static_cast<char>(0x80U | ((c >> (6 * i)) & 0x3fU));
    }
  }
  return result;
}

bool isWhiteSpace(char32_t c) {
  return isIn(c, 0x09, 0x0d) || c == ' ' || c == 0x85 || c == 0xa0 || c == 0x1680 ||
         isIn(c, 0x2000, 0x200a) || c == 0x2028 || c == 0x2029 || c == 0x202f || c == 0x205f ||
         c == 0x3000;
}

bool isDigit(char32_t c) { return isIn(c, '0', '9'); }

bool isLetter(char32_t c) {
  if (isAscii(c)) return isIn(c | 0x20U, 'a', 'z');
  if (isIn(c, 0x300, 0x36f)) return false;
  return unicodeLocale() == nullptr || iswalpha_l(static_cast<wint_t>(c), unicodeLocale()) != 0;
}

char32_t toLower(char32_t c) {
  if (isAscii(c)) return isIn(c, 'A', 'Z') ? c | 0x20U : c;
  if (unicodeLocale() == nullptr) return c;
  return static_cast<char32_t>(towlower_l(static_cast<wint_t>(c), unicodeLocale()));
}

}  // namespace tsg::language
