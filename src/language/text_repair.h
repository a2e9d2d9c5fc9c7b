// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unicode/unistr.h>

/// Repair of text as the Python package ftfy does by default; internal to the module.
///
/// deviation: mojibake (text decoded with the wrong character set, "cafÃ©" for "café") is not
/// repaired: ftfy guesses there, by statistics.
namespace tsg::language {

/// Line by line, until nothing changes: HTML references decoded (not in or after a line with '<'),
/// C1 controls read as Windows-1252, Latin ligatures taken apart, full and half width made normal,
/// quotation marks straightened, line ends made "\n", terminal escapes and control characters
/// removed, NFC. O(length).
icu::UnicodeString repairText(const icu::UnicodeString& text);

}  // namespace tsg::language
