// SPDX-License-Identifier: BSD-3-Clause
#include "text_repair.h"

#include <optional>

#include "html_entities.h"
#include "unicode.h"

namespace tsg::language {
namespace {

bool isIn(UChar32 code_point, UChar32 first, UChar32 last) {
  return code_point >= first && code_point <= last;
}

bool isLatinLigature(UChar32 code_point) {
  return code_point == 0x132 || code_point == 0x133 || code_point == 0x149 ||
         isIn(code_point, 0x1c4, 0x1cc) || isIn(code_point, 0x1f1, 0x1f3) ||
         isIn(code_point, 0xfb00, 0xfb06);
}

bool isUnusualWidth(UChar32 code_point) {
  return code_point == 0x3000 || isIn(code_point, 0xff01, 0xffef);
}

/// Control characters that are neither white space nor change how their neighbours look.
bool isUselessControl(UChar32 code_point) {
  return isIn(code_point, 0x00, 0x08) || code_point == 0x0b || isIn(code_point, 0x0e, 0x1f) ||
         code_point == 0x7f || isIn(code_point, 0x206a, 0x206f) || code_point == 0xfeff ||
         isIn(code_point, 0xfff9, 0xfffc);
}

icu::UnicodeString straightenCharacter(UChar32 code_point) {
  constexpr UChar32 kLongStLigature = 0xfb05;  // NFKC would replace the long s, too
  const UChar32 character = decodeWindows1252(code_point);
  if (character == kLongStLigature) return icu::UnicodeString::fromUTF8("\u017ft");
  if (isLatinLigature(character) || isUnusualWidth(character)) {
    return normalizeNfkc(icu::UnicodeString(character));
  }
  return icu::UnicodeString(character);
}

icu::UnicodeString straightenCharacters(const icu::UnicodeString& text) {
  icu::UnicodeString result;
  for (std::int32_t at = 0; at < text.length(); at = text.moveIndex32(at, 1)) {
    result.append(straightenCharacter(text.char32At(at)));
  }
  return result;
}

icu::UnicodeString removeUselessControls(const icu::UnicodeString& text) {
  icu::UnicodeString result;
  for (std::int32_t at = 0; at < text.length(); at = text.moveIndex32(at, 1)) {
    const UChar32 character = text.char32At(at);
    if (!isUselessControl(character)) result.append(character);
  }
  return result;
}

icu::UnicodeString applyRepairsOnce(const icu::UnicodeString& line, bool unescapes_html) {
  static const icu::RegexPattern kDoubleQuotes = compilePattern(R"([\u201c-\u201f])");
  static const icu::RegexPattern kSingleQuotes = compilePattern(R"([\u02bc\u2018-\u201b])");
  static const icu::RegexPattern kLineEnds = compilePattern(R"(\r\n|[\r\u2028\u2029\u0085])");
  static const icu::RegexPattern kTerminalEscapes = compilePattern(R"(\u001b\[[\p{Nd};]*[a-zA-Z])");
  icu::UnicodeString text = unescapes_html ? unescapeClearHtml(line) : line;
  text = straightenCharacters(text);
  text = replaceAll(kDoubleQuotes, text, u"\"");
  text = replaceAll(kSingleQuotes, text, u"'");
  text = replaceAll(kLineEnds, text, u"\n");
  text = replaceAll(kTerminalEscapes, text, u"");
  return normalizeNfc(removeUselessControls(text));
}

icu::UnicodeString repairLine(icu::UnicodeString line, bool unescapes_html) {
  while (true) {
    const icu::UnicodeString repaired = applyRepairsOnce(line, unescapes_html);
    if (repaired == line) return line;
    line = repaired;
  }
}

}  // namespace

icu::UnicodeString repairText(const icu::UnicodeString& text) {
  icu::UnicodeString result;
  bool unescapes_html = true;
  for (std::int32_t begin = 0; begin < text.length();) {
    const std::int32_t line_end = text.indexOf(u'\n', begin);
    const std::int32_t end = line_end < 0 ? text.length() : line_end + 1;
    const icu::UnicodeString line = text.tempSubStringBetween(begin, end);
    unescapes_html = unescapes_html && line.indexOf(u'<') < 0;
    result.append(repairLine(line, unescapes_html));
    begin = end;
  }
  return result;
}

}  // namespace tsg::language
