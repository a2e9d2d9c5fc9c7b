// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace tsg::language {

/// Cleans a prompt: straight quotation marks, runs of white space made one space, none at the ends,
/// lower case. That is what open_clip's tokenizer does to texts that people type.
///
/// deviation: its repair of damaged text from the web is left out (HTML references, mojibake,
/// composed accents, ligatures, widths, control characters).
/// @param utf8_text any valid UTF-8.
/// @throws std::invalid_argument if the text is not valid UTF-8. O(length); thread-safe.
std::string cleanText(const std::string& utf8_text);

/// Splits a clean text into the words that byte pair encoding works on: English contractions
/// ('s 't 're 've 'm 'll 'd), runs of letters, single digits, runs of everything else but spaces,
/// and the marks <start_of_text> and <end_of_text>.
///
/// deviation: letters are the C library's, digits 0 to 9; CLIP takes Unicode's \p{L} and \p{N},
/// which differ beyond Latin, Greek and Cyrillic.
/// @throws std::invalid_argument if the text is not valid UTF-8. O(length); thread-safe.
std::vector<std::string> splitWords(const std::string& clean_utf8_text);

}  // namespace tsg::language
