// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace tsg::plausibility {

/// One line of the plausibility report: something that is unusual, not something that failed.
struct Finding {
  std::string check;    ///< stable key, such as "depth scale" (docs/plausibility.md lists them)
  std::string seen;     ///< what was measured, with its numbers
  std::string meaning;  ///< what that usually means
  std::string remedy;   ///< what to set or look at
};

/// "check: seen; meaning; remedy", one line.
std::string toText(const Finding& finding);

/// True if one of the findings has this key.
bool hasFinding(const std::vector<Finding>& findings, const std::string& check);

/// 0.973 -> "97 %", 0.001 -> "under 1 %", 0.999 -> "over 99 %".
std::string formatShare(double share);

/// At most three significant digits: 0.000199 -> "0.000199", 2500.3 -> "2500".
std::string formatNumber(double value);

}  // namespace tsg::plausibility
