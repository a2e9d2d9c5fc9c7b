// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "task_scene_graph/config/config.h"

/// The parameters in force, each with its value and where that comes from.
namespace tsg::config {

/// Origin of a parameter that no source gave.
constexpr const char* kDefaultOrigin = "default";

/// Section of a file of settings that says what it was made with; not read back.
constexpr const char* kRecordSection = "made_with";

struct Setting {
  std::string name;    ///< with the groups it lies in: "input/sync_tolerance_s"
  std::string value;   ///< YAML, in one line; numbers keep every digit, strings are quoted
  std::string origin;  ///< name of its source, or kDefaultOrigin
};

/// The settings of one stage.
struct StageSettings {
  std::string stage;
  std::vector<Setting> settings;
};

/// One line of a YAML map: `name` with its groups, the value as YAML, a comment or none.
struct YamlLine {
  std::string name;
  std::string value;
  std::string comment;
};

/// Writes lines as nested maps; those of one group must follow each other.
void writeYaml(std::ostream& stream, const std::vector<YamlLine>& lines);

/// Writes settings as a configuration file that gives the same settings when it is read (see
/// config_file.h). What tracker and mesh_fusion agree on in their groups `input` is written once,
/// as the shared section.
/// @param record  lines of the section `made_with`: what the settings were used for
void writeSettings(std::ostream& stream, const std::vector<YamlLine>& record,
                   const std::vector<StageSettings>& stages);

namespace internal {

std::string toYamlText(bool value);
std::string toYamlText(int value);
std::string toYamlText(double value);
std::string toYamlText(const std::string& value);
std::string toYamlText(const std::filesystem::path& value);
std::string toYamlText(const NumbersOrPath& value);
template <typename T>
std::string toYamlText(const std::vector<T>& values) {
  std::string text;
  for (const T& value : values) text += (text.empty() ? "" : ", ") + toYamlText(value);
  return "[" + text + "]";
}

/// Lists every field of a configuration.
class SettingLister {
 public:
  SettingLister(std::string path, const Origins& origins, std::vector<Setting>& settings)
      : path_(std::move(path)), origins_(origins), settings_(settings) {}

  template <typename T>
  void field(const char* name, const T& value, Range, const char*, const char*) {
    add(name, toYamlText(value));
  }
  template <typename Enum>
  void choice(const char* name, const Enum& value, const Choices<Enum>& choices, const char*) {
    add(name, findChoiceName(value, choices));
  }
  template <typename Config>
  void group(const char* name, const Config& config) {
    SettingLister lister(joinPath(path_, name), origins_, settings_);
    Config::visit(config, lister);
  }

 private:
  void add(const std::string& name, const std::string& value);

  std::string path_;
  const Origins& origins_;
  std::vector<Setting>& settings_;
};

}  // namespace internal

/// Every parameter of a configuration, in order of declaration.
template <typename Config>
std::vector<Setting> listSettings(const Config& config, const Origins& origins) {
  std::vector<Setting> settings;
  internal::SettingLister lister("", origins, settings);
  Config::visit(config, lister);
  return settings;
}

}  // namespace tsg::config
