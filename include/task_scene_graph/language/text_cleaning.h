// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace tsg::language {

/// Cleans a prompt as open_clip's tokenizer does by default: broken text repaired (NFC, straight
/// quotation marks, normal width, no control characters), HTML references decoded twice, runs of
/// white space made one space, none at the ends, lower case.
///
/// deviation: mojibake is not repaired, and of HTML's names those of HTML 4 are known.
/// @param utf8_text any valid UTF-8.
/// @throws std::invalid_argument if the text is not valid UTF-8. O(length); thread-safe.
std::string cleanText(const std::string& utf8_text);

/// Splits a clean text into the words that byte pair encoding works on: English contractions
/// ('s 't 're 've 'm 'll 'd), runs of letters, single digits, runs of everything else but spaces,
/// and the marks <start_of_text> and <end_of_text>.
/// @throws std::invalid_argument if the text is not valid UTF-8. O(length); thread-safe.
std::vector<std::string> splitWords(const std::string& clean_utf8_text);

}  // namespace tsg::language
