// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace tsg::config {

/// A text whose last line is ended: yaml-cpp 0.6 (Ubuntu 20.04, Debian 11) never comes back from
/// "[5:" at the very end of one.
inline std::string endLine(std::string yaml) {
  if (!yaml.empty() && yaml.back() != '\n') yaml += '\n';
  return yaml;
}

}  // namespace tsg::config
