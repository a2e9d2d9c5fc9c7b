// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "task_scene_graph/core/embedding.h"

namespace tsg::scene_graph {

/// Reads a number of JSON's grammar as strtod() does, and rounds it to a float: the same bits, ten
/// times as fast. Returns where it ends; `text` where none begins, or where it is beyond a double.
/// `text` ends with a character that is of no number.
const char* parseNumber(const char* text, float& value);

/// Appends the shortest text that is read as the same number; null where it is not finite.
void appendNumber(float value, std::string& text);
void appendNumber(double value, std::string& text);
/// Appends "[a,b,c]".
void appendNumbers(const Embedding& values, std::string& text);

}  // namespace tsg::scene_graph
