// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/plausibility/finding.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tsg::plausibility {

std::string toText(const Finding& finding) {
  return finding.check + ": " + finding.seen + "; " + finding.meaning + "; " + finding.remedy;
}

bool hasFinding(const std::vector<Finding>& findings, const std::string& check) {
  return std::any_of(findings.begin(), findings.end(),
                     [&](const Finding& finding) { return finding.check == check; });
}

std::string formatShare(double share) {
  if (share > 0.0 && share < 0.005) return "under 1 %";
  if (share < 1.0 && share >= 0.995) return "over 99 %";
  return std::to_string(std::lround(100.0 * share)) + " %";
}

std::string formatNumber(double value) {
  char text[40];
  const double magnitude = std::abs(value);
  const bool is_large = magnitude >= 1000.0 && magnitude < 1e7;
  std::snprintf(text, sizeof text, is_large ? "%.0f" : "%.3g", value);
  return text;
}

}  // namespace tsg::plausibility
