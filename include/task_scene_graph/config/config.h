// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "task_scene_graph/config/scalar.h"
#include "task_scene_graph/config/visitor.h"

namespace tsg::config {

/// Every violation found in a configuration, one per line.
class ConfigError : public std::runtime_error {
 public:
  ConfigError(const std::string& where, const std::vector<std::string>& violations);
  /// One that says where it is.
  explicit ConfigError(const std::string& problem);
};

/// One place in which parameters are given.
struct Source {
  std::string name;              ///< for people: "file '/home/u/my.yaml'"; "" is not mentioned
  YAML::Node parameters;         ///< a map; null and undefined hold nothing
  std::filesystem::path folder;  ///< where relative paths in it begin; empty: the current folder
};

/// Name of the source of each parameter that some source gave: "tsdf/voxel_size_m" -> "file '...'".
using Origins = std::map<std::string, std::string>;

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
/// The name of a choice as people write it: "color-to-depth" is "color_to_depth".
std::string toChoiceName(std::string text);

/// The first name of a choice; "" if it has none.
template <typename Enum>
std::string findChoiceName(Enum value, const Choices<Enum>& choices) {
  for (const auto& [text, option] : choices) {
    if (option == value) return text;
  }
  return "";
}

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
struct TypeName<std::filesystem::path> {
  static constexpr const char* value = "path";
};
template <>
struct TypeName<NumbersOrPath> {
  static constexpr const char* value = "numbers or path";
};
template <>
struct TypeName<std::vector<std::string>> {
  static constexpr const char* value = "list of strings";
};
template <>
struct TypeName<std::vector<double>> {
  static constexpr const char* value = "list of numbers";
};

/// Read a value out of a YAML node as scalar.h says; false, with `value` unchanged or not, if it is
/// not of that type. Strings that are a number or a boolean to a parameter server are none.
bool read(const YAML::Node& node, bool& value);
bool read(const YAML::Node& node, int& value);
bool read(const YAML::Node& node, double& value);
bool read(const YAML::Node& node, std::string& value);
template <typename T>
bool read(const YAML::Node& node, std::vector<T>& values) {
  if (!node.IsSequence()) return false;
  std::vector<T> items(node.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (!read(node[i], items[i])) return false;
  }
  values = std::move(items);
  return true;
}

/// Reads one source into a struct; gathers violations instead of throwing at the first.
class Loader {
 public:
  /// `origins` may be null.
  Loader(const Source& source, std::vector<std::string>& violations, Origins* origins);
  /// Reports keys that no field asked for, with the nearest known name, and keys that are there
  /// twice.
  void finish() const;

  template <typename T>
  void field(const char* name, T& value, Range, const char*, const char*) {
    const YAML::Node node = consume(name);
    if (!node.IsDefined()) return;
    if (!read(node, value)) return wrongType(name, node, TypeName<T>::value);
    noteOrigin(name);
  }
  void field(const char* name, std::filesystem::path& value, Range, const char*, const char*);
  void field(const char* name, NumbersOrPath& value, Range, const char*, const char*);

  template <typename Enum>
  void choice(const char* name, Enum& value, const Choices<Enum>& choices, const char*) {
    const YAML::Node node = consume(name);
    if (!node.IsDefined()) return;
    std::string names;
    for (const auto& [text, option] : choices) {
      if (node.IsScalar() && toChoiceName(node.Scalar()) == text) {
        value = option;
        return noteOrigin(name);
      }
      names += (names.empty() ? "" : ", ") + text;
    }
    wrongType(name, node, "one of " + names);
  }

  template <typename Config>
  void group(const char* name, Config& config) {
    const YAML::Node node = consume(name);
    if (!node.IsDefined() || node.IsNull()) return;
    Loader loader(*this, node, name);
    Config::visit(config, loader);
    loader.finish();
  }

 private:
  Loader(const Loader& parent, const YAML::Node& map, const std::string& group);
  void checkIsMap();
  /// A path relative to the source's folder; reports what is none.
  std::optional<std::filesystem::path> expand(const std::string& name, const std::string& text);
  YAML::Node consume(const std::string& name);
  void noteOrigin(const std::string& name);
  void report(const std::string& problem) const;
  void wrongType(const std::string& name, const YAML::Node& node, const std::string& expected);

  const Source& source_;
  YAML::Node map_;
  std::string path_;
  std::vector<std::string>& violations_;
  Origins* origins_;
  std::set<std::string> known_;
};

/// " (file '/home/u/my.yaml')", or "" where there is no name.
std::string mention(const std::string& source);

class Checker {
 public:
  Checker(std::string path, std::vector<std::string>& violations, const Origins* origins)
      : path_(std::move(path)), violations_(violations), origins_(origins) {}

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
    Checker checker(joinPath(path_, name), violations_, origins_);
    Config::visit(config, checker);
  }

 private:
  void check(const std::string& name, double value, Range range, const std::string& unit);

  std::string path_;
  std::vector<std::string>& violations_;
  const Origins* origins_;  ///< may be null
};

/// The names at the top level of a configuration.
class NameLister {
 public:
  std::vector<std::string> names;

  template <typename T>
  void field(const char* name, const T&, Range, const char*, const char*) {
    names.emplace_back(name);
  }
  template <typename Enum>
  void choice(const char* name, const Enum&, const Choices<Enum>&, const char*) {
    names.emplace_back(name);
  }
  template <typename Config>
  void group(const char* name, const Config&) {
    names.emplace_back(name);
  }
};

class Writer {
 public:
  YAML::Node map{YAML::NodeType::Map};

  template <typename T>
  void field(const char* name, const T& value, Range, const char*, const char*) {
    if constexpr (std::is_same_v<T, std::filesystem::path>) {
      map[name] = value.string();
    } else if constexpr (std::is_same_v<T, NumbersOrPath>) {
      map[name] = value.text;
    } else {
      map[name] = value;
    }
  }
  template <typename Enum>
  void choice(const char* name, const Enum& value, const Choices<Enum>& choices, const char*) {
    map[name] = findChoiceName(value, choices);
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
    } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
      text = '"' + value.string() + '"';
    } else if constexpr (std::is_same_v<T, NumbersOrPath>) {
      text = '"' + value.text + '"';
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
    FieldDoc row{joinPath(path_, name), "choice", findChoiceName(value, choices), "", "", doc};
    for (const auto& [text, option] : choices) {
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
  internal::Checker checker("", violations, nullptr);
  Config::visit(config, checker);
  internal::throwIfAny(where, violations);
}

/// Reads sources one after the other, so that later ones win; what none gives keeps `defaults`.
/// @param origins  if not null, gets the source of each parameter that was given
/// @throws ConfigError with all violations, each naming its source: unknown keys (with the nearest
/// known one), keys that are there twice, empty values, wrong types, values out of range.
template <typename Config>
Config load(const std::vector<Source>& sources, const std::string& where, Config defaults = {},
            Origins* origins = nullptr) {
  std::vector<std::string> violations;
  Origins found;
  for (const Source& source : sources) {
    internal::Loader loader(source, violations, &found);
    Config::visit(defaults, loader);
    loader.finish();
  }
  internal::Checker checker("", violations, &found);
  Config::visit(static_cast<const Config&>(defaults), checker);
  internal::throwIfAny(where, violations);
  if (origins != nullptr) *origins = std::move(found);
  return defaults;
}

/// The same with one source, which `where` names.
template <typename Config>
Config load(const YAML::Node& map, const std::string& where, Config defaults = {}) {
  return load(std::vector<Source>{{"", map, {}}}, where, std::move(defaults));
}

/// Names of the fields, choices and groups at the top level of a configuration.
template <typename Config>
std::vector<std::string> listNames() {
  internal::NameLister lister;
  const Config config{};
  Config::visit(config, lister);
  return lister.names;
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

/// Parses a YAML file. @throws ConfigError naming the file by its full path, and the line where
/// there is one, if it is absent, a folder, unreadable or malformed, or holds several documents.
YAML::Node loadYamlFile(const std::string& path);

/// The candidate nearest to `name` in edit distance, or "" if none comes near. O(len^2 *
/// candidates).
std::string findNearestName(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace tsg::config
