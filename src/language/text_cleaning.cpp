// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/text_cleaning.h"

#include <unicode/locid.h>
#include <unicode/uchar.h>

#include <stdexcept>

#include "html_entities.h"
#include "text_repair.h"
#include "unicode.h"

namespace tsg::language {
namespace {

icu::UnicodeString collapseWhiteSpace(const icu::UnicodeString& text) {
  icu::UnicodeString result;
  bool has_gap = false;
  for (std::int32_t at = 0; at < text.length(); at = text.moveIndex32(at, 1)) {
    const UChar32 character = text.char32At(at);
    if (u_isUWhiteSpace(character)) {
      has_gap = true;
      continue;
    }
    if (has_gap && !result.isEmpty()) result.append(u' ');
    has_gap = false;
    result.append(character);
  }
  return result;
}

}  // namespace

std::string cleanText(const std::string& utf8_text) {
  icu::UnicodeString text = repairText(toUnicode(utf8_text));
  // Twice, since texts from the web are often escaped twice ("&amp;eacute;").
  text = collapseWhiteSpace(unescapeHtml(unescapeHtml(text)));
  return toUtf8(text.toLower(icu::Locale::getRoot()));
}

std::vector<std::string> splitWords(const std::string& clean_utf8_text) {
  // Only the first part ignores case (so that a long s is an s): ICU would else count characters as
  // letters that merely fold to one. U+0345 folds to a letter and is none, so open_clip's pattern,
  // which ignores case everywhere, lets it fall between its two classes: it is in no word.
  static const icu::RegexPattern kWord =
      compilePattern(R"((?i:<start_of_text>|<end_of_text>|'s|'t|'re|'ve|'m|'ll|'d))"
                     R"(|\p{L}+|\p{N}|[^\s\p{L}\p{N}\u0345]+)");
  const icu::UnicodeString text = toUnicode(clean_utf8_text);
  UErrorCode status = U_ZERO_ERROR;
  const std::unique_ptr<icu::RegexMatcher> matcher(kWord.matcher(text, status));
  std::vector<std::string> words;
  while (U_SUCCESS(status) && matcher->find(status)) {
    words.push_back(toUtf8(matcher->group(status)));
  }
  if (U_FAILURE(status)) throw std::logic_error("splitting a text into words failed");
  return words;
}

}  // namespace tsg::language
