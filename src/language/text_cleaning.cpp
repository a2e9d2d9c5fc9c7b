// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/text_cleaning.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "unicode.h"

namespace tsg::language {
namespace {

/// Word processors' and phones' quotation marks as a keyboard's.
char32_t straightenQuote(char32_t c) {
  if (c >= 0x201c && c <= 0x201f) return U'"';
  if ((c >= 0x2018 && c <= 0x201b) || c == 0x02bc) return U'\'';
  return c;
}

/// Words that stand for themselves, wherever they begin.
constexpr std::array<std::u32string_view, 9> kFixedWords = {
    U"<start_of_text>", U"<end_of_text>", U"'s", U"'t", U"'re", U"'ve", U"'m", U"'ll", U"'d"};

std::size_t findEnd(const std::u32string& text, std::size_t begin, bool (*is_inside)(char32_t)) {
  const auto end =
      std::find_if_not(text.begin() + static_cast<std::ptrdiff_t>(begin), text.end(), is_inside);
  return static_cast<std::size_t>(end - text.begin());
}

bool isSymbol(char32_t c) { return !isWhiteSpace(c) && !isLetter(c) && !isDigit(c); }

/// End of the word that begins here, by the order of CLIP's pattern.
std::size_t findWordEnd(const std::u32string& text, std::size_t begin) {
  for (const auto word : kFixedWords) {
    if (text.compare(begin, word.size(), word) == 0) return begin + word.size();
  }
  if (isLetter(text[begin])) return findEnd(text, begin, isLetter);
  return isDigit(text[begin]) ? begin + 1 : findEnd(text, begin, isSymbol);
}

}  // namespace

std::string cleanText(const std::string& utf8_text) {
  std::u32string clean;
  for (const char32_t c : decodeUtf8(utf8_text)) {
    const bool is_gap = isWhiteSpace(c);
    if (is_gap && (clean.empty() || clean.back() == U' ')) continue;
    clean += is_gap ? U' ' : toLower(straightenQuote(c));
  }
  if (!clean.empty() && clean.back() == U' ') clean.pop_back();
  return encodeUtf8(clean);
}

std::vector<std::string> splitWords(const std::string& clean_utf8_text) {
  const std::u32string text = decodeUtf8(clean_utf8_text);
  std::vector<std::string> words;
  for (std::size_t at = 0; at < text.size();) {
    if (isWhiteSpace(text[at])) {
      ++at;
      continue;
    }
    const std::size_t end = findWordEnd(text, at);
    words.push_back(encodeUtf8(text.substr(at, end - at)));
    at = end;
  }
  return words;
}

}  // namespace tsg::language
