// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unicode/regex.h>
#include <unicode/unistr.h>

#include <string>

/// Thin helpers over ICU; internal to the module.
namespace tsg::language {

/// @throws std::invalid_argument if the text is not valid UTF-8.
icu::UnicodeString toUnicode(const std::string& utf8_text);
std::string toUtf8(const icu::UnicodeString& text);

/// A pattern that is part of the program. @throws std::logic_error if it is malformed.
icu::RegexPattern compilePattern(const char* pattern);

/// All matches replaced by `replacement`, in which `$` and `\` are special as in ICU.
icu::UnicodeString replaceAll(const icu::RegexPattern& pattern, const icu::UnicodeString& text,
                              const icu::UnicodeString& replacement);

icu::UnicodeString normalizeNfc(const icu::UnicodeString& text);
icu::UnicodeString normalizeNfkc(const icu::UnicodeString& text);

/// What byte 0x80 + i means in Windows-1252; the byte itself where it means nothing.
UChar32 decodeWindows1252(UChar32 byte);

}  // namespace tsg::language
