// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>
#include <vector>

/// What the text of a YAML scalar means: one answer for files, which are read as text, and for the
/// parameter server, whose values rosparam (PyYAML, YAML 1.1) or roscpp have parsed before.
namespace tsg::config {

/// A number: "3", "-2.5", ".5", "1e-3", "1E5", "1_000", "0x1F", "0b101", ".inf", "-.inf", ".nan".
/// Nothing for any other text, among it what YAML 1.1 and 1.2 read differently ("010": 8 or 10) and
/// decimals too large for a double.
std::optional<double> parseNumber(const std::string& text);

/// A whole number, which may be written as one of parseNumber's ("2.0", "1e3"). Nothing for
/// fractions and what does not fit into an int.
std::optional<int> parseInteger(const std::string& text);

/// Numbers, as strtod reads them, apart by blanks, commas, semicolons or brackets; nothing if there
/// is anything else. No number in an empty text.
std::optional<std::vector<double>> parseNumbers(std::string text);

/// true, yes, on, y or false, no, off, n, each in lower case, upper case or with a capital.
std::optional<bool> parseBool(const std::string& text);

/// The shortest decimal that is read back as the same double; ".inf", "-.inf", ".nan".
std::string formatExactly(double value);

/// What is wrong with a scalar that should be a number, where that is known: ", is it octal or
/// decimal? ..."; else "".
std::string explainNumber(const std::string& text);

/// The YAML text of a string that every reader takes for that string: in double quotes.
std::string quoteYaml(const std::string& text);

/// Tags of scalars that were typed before they came here: a parameter server's bool, int, double.
/// They are no strings.
constexpr const char* kBoolTag = "tag:yaml.org,2002:bool";
constexpr const char* kIntTag = "tag:yaml.org,2002:int";
constexpr const char* kFloatTag = "tag:yaml.org,2002:float";

/// A value in one line, for messages: abc, [1, 2], {a: 1}.
std::string formatNode(const YAML::Node& node);

/// The kind of a typed scalar in words ("the boolean true", "the number 8"); "" for text.
std::string describeTyped(const YAML::Node& scalar);

}  // namespace tsg::config
