// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace tsg {

/// Whether all bytes are well-formed UTF-8: none overlong, no surrogates, nothing beyond U+10FFFF.
/// O(length).
bool isValidUtf8(const std::string& text);

}  // namespace tsg
