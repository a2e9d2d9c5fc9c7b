// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

/// What yaml-cpp 0.6 (Ubuntu 20.04, Debian 11) never comes back from.
namespace tsg::config {

/// A text whose last line is ended: "[5:" at the very end of one is such.
std::string endLine(std::string yaml);

/// What is wrong with a text that has ":]" inside brackets, with the number of the line; "" if
/// nothing is.
std::string findEndlessBrackets(const std::string& yaml);

}  // namespace tsg::config
