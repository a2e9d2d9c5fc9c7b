// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unicode/unistr.h>

/// HTML character references; internal to the module.
///
/// deviation: of the 2231 names of HTML 5 only those of HTML 4 (252), `apos` and the capital forms
/// AMP, COPY, GT, LT, QUOT, REG, TRADE are known; text with another one is left as it is.
namespace tsg::language {

/// Replaces references as a browser does: "&amp;", "&#233;", "&#xe9;", also without the semicolon
/// where old HTML allowed that ("&eacute", "&ampx" = "&x"). Numbers that stand for no character are
/// dropped, those of surrogates become U+FFFD. O(length).
icu::UnicodeString unescapeHtml(const icu::UnicodeString& text);

/// As `unescapeHtml`, but only what is beyond doubt: references that end in a semicolon. Names in
/// capitals stand for capital letters ("&NTILDE;"). O(length).
icu::UnicodeString unescapeClearHtml(const icu::UnicodeString& text);

}  // namespace tsg::language
