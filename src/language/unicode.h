// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

/// What of Unicode the tokenizer needs; internal to the module. Letters and their cases are those
/// of the C library's locale C.UTF-8; where there is none, ASCII has cases and all beyond it is a
/// letter. Thread-safe.
namespace tsg::language {

/// @throws std::invalid_argument if the text is not valid UTF-8.
std::u32string decodeUtf8(const std::string& text);
std::string encodeUtf8(const std::u32string& text);

bool isWhiteSpace(char32_t c);
bool isDigit(char32_t c);
/// Digits are no letters, nor are the marks that combine with one (U+0300 to U+036F).
bool isLetter(char32_t c);
char32_t toLower(char32_t c);

}  // namespace tsg::language
