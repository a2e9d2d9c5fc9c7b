// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <yaml-cpp/yaml.h>

#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "task_scene_graph/config/visitor.h"

namespace tsg::config {

/// Every violation found in a configuration, one per line.
class ConfigError : public std::runtime_error {
 public:
  ConfigError(const std::string& where, const std::vector<std::string>& violations);
};

/// One row of a parameter table.
struct FieldDoc {
  std::string name;  ///< with the groups it lies in: "tsdf/voxel_size_m"
  std::string type;
  std::string default_value;
  std::string range;
  std::string unit;
  std::string doc;
};

namespace internal {

std::string formatNumber(double value);
std::string formatRange(Range range);
std::string joinPath(const std::string& path, const std::string& name);

template <typename T>
struct TypeName;
template <>
struct TypeName<bool> {
  static constexpr const char* value = "bool";
};
template <>
struct TypeName<int> {
  static constexpr const char* value = "int";
};
template <>
struct TypeName<double> {
  static constexpr const char* value = "double";
};
template <>
struct TypeName<std::string> {
  static constexpr const char* value = "string";
};
template <>
struct TypeName<std::vector<std::string>> {
  static constexpr const char* value = "list of strings";
};
template <>
struct TypeName<std::vector<double>> {
  static constexpr const char* value = "list of numbers";
};

/// Reads a YAML map into a struct; gathers violations instead of throwing at the first.
class Loader {
 public:
  Loader(const YAML::Node& map, std::string path, std::vector<std::string>& violations);
  /// Reports keys that no field asked for, with the nearest known name.
  void finish() const;

  template <typename T>
  void field(const char* name, T& value, Range, const char*, const char*) {
    const YAML::Node node = take(name);
    if (!node.IsDefined()) return;
    try {
      value = node.as<T>();
    } catch (const YAML::Exception&) {
      wrongType(name, node, TypeName<T>::value);
    }
  }

  template <typename Enum>
  void choice(const char* name, Enum& value, const Choices<Enum>& choices, const char*) {
    const YAML::Node node = take(name);
    if (!node.IsDefined()) return;
    std::string names;
    for (const auto& [text, option] : choices) {
      if (node.IsScalar() && node.Scalar() == text) {
        value = option;
        return;
      }
      names += (names.empty() ? "" : ", ") + text;
    }
    wrongType(name, node, "one of " + names);
  }

  template <typename Config>
  void group(const char* name, Config& config) {
    const YAML::Node node = take(name);
    if (!node.IsDefined() || node.IsNull()) return;
    Loader loader(node, joinPath(path_, name), violations_);
    Config::visit(config, loader);
    loader.finish();
  }

 private:
  YAML::Node take(const std::string& name);
  void wrongType(const std::string& name, const YAML::Node& node, const std::string& expected);

  YAML::Node map_;
  std::string path_;
  std::vector<std::string>& violations_;
  std::set<std::string> known_;
};

class Checker {
 public:
  Checker(std::string path, std::vector<std::string>& violations)
      : path_(std::move(path)), violations_(violations) {}

  template <typename T>
  void field([[maybe_unused]] const char* name, const T& value, [[maybe_unused]] Range range,
             [[maybe_unused]] const char* unit, const char*) {
    if constexpr (std::is_same_v<T, int> || std::is_same_v<T, double>) {
      check(name, static_cast<double>(value), range, unit);
    } else if constexpr (std::is_same_v<T, std::vector<double>>) {
      for (const double item : value) check(name, item, range, unit);
    }
  }
  template <typename Enum>
  void choice(const char*, const Enum&, const Choices<Enum>&, const char*) {}
  template <typename Config>
  void group(const char* name, const Config& config) {
    Checker checker(joinPath(path_, name), violations_);
    Config::visit(config, checker);
  }

 private:
  void check(const std::string& name, double value, Range range, const std::string& unit);

  std::string path_;
  std::vector<std::string>& violations_;
};

class Writer {
 public:
  YAML::Node map{YAML::NodeType::Map};

  template <typename T>
  void field(const char* name, const T& value, Range, const char*, const char*) {
    map[name] = value;
  }
  template <typename Enum>
  void choice(const char* name, const Enum& value, const Choices<Enum>& choices, const char*) {
    for (const auto& [text, option] : choices) {
      if (option == value) map[name] = text;
    }
  }
  template <typename Config>
  void group(const char* name, const Config& config) {
    Writer writer;
    Config::visit(config, writer);
    map[name] = writer.map;
  }
};

class Documenter {
 public:
  Documenter(std::string path, std::vector<FieldDoc>& rows) : path_(std::move(path)), rows_(rows) {}

  template <typename T>
  void field(const char* name, const T& value, Range range, const char* unit, const char* doc) {
    std::string text;
    if constexpr (std::is_same_v<T, int> || std::is_same_v<T, double>) {
      text = formatNumber(static_cast<double>(value));
    } else if constexpr (std::is_same_v<T, bool>) {
      text = value ? "true" : "false";
    } else if constexpr (std::is_same_v<T, std::string>) {
      text = '"' + value + '"';
    } else if constexpr (std::is_same_v<T, std::vector<double>>) {
      for (const double item : value) text += (text.empty() ? "" : ", ") + formatNumber(item);
      text = '[' + text + ']';
    } else {
      for (const auto& item : value) text += (text.empty() ? "" : ", ") + item;
      text = '[' + text + ']';
    }
    rows_.push_back(
        {joinPath(path_, name), TypeName<T>::value, text, formatRange(range), unit, doc});
  }
  template <typename Enum>
  void choice(const char* name, const Enum& value, const Choices<Enum>& choices, const char* doc) {
    FieldDoc row{joinPath(path_, name), "choice", "", "", "", doc};
    for (const auto& [text, option] : choices) {
      if (option == value) row.default_value = text;
      row.range += (row.range.empty() ? "" : ", ") + text;
    }
    rows_.push_back(row);
  }
  template <typename Config>
  void group(const char* name, const Config& config) {
    Documenter documenter(joinPath(path_, name), rows_);
    Config::visit(config, documenter);
  }

 private:
  std::string path_;
  std::vector<FieldDoc>& rows_;
};

void throwIfAny(const std::string& where, const std::vector<std::string>& violations);

}  // namespace internal

/// Checks every range. @throws ConfigError with all violations; `where` says whose configuration it
/// is.
template <typename Config>
void validate(const Config& config, const std::string& where) {
  std::vector<std::string> violations;
  internal::Checker checker("", violations);
  Config::visit(config, checker);
  internal::throwIfAny(where, violations);
}

/// Reads a YAML map; fields that are absent keep `defaults`. @throws ConfigError with all
/// violations: unknown keys (with the nearest known one), wrong types, values out of range.
template <typename Config>
Config load(const YAML::Node& map, const std::string& where, Config defaults = {}) {
  std::vector<std::string> violations;
  internal::Loader loader(map, "", violations);
  Config::visit(defaults, loader);
  loader.finish();
  internal::Checker checker("", violations);
  Config::visit(static_cast<const Config&>(defaults), checker);
  internal::throwIfAny(where, violations);
  return defaults;
}

/// The struct as a YAML map that `load` reads back to an equal struct.
template <typename Config>
YAML::Node toYaml(const Config& config) {
  internal::Writer writer;
  Config::visit(config, writer);
  return writer.map;
}

/// One row per field, in order of declaration.
template <typename Config>
std::vector<FieldDoc> describe() {
  std::vector<FieldDoc> rows;
  internal::Documenter documenter("", rows);
  const Config config{};
  Config::visit(config, documenter);
  return rows;
}

/// Parses a YAML file. @throws ConfigError naming the file and the line if it is absent or
/// malformed.
YAML::Node loadYamlFile(const std::string& path);

/// The candidate nearest to `name` in edit distance, or "" if none comes near. O(len^2 *
/// candidates).
std::string findNearestName(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace tsg::config
