// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/config/config_file.h"

#include <algorithm>
#include <set>

#include "task_scene_graph/config/settings.h"

namespace tsg::config {
namespace {

constexpr const char* kInput = "input";
constexpr const char* kWorldFrame = "world_frame";

const std::vector<std::string>& listShared() {
  static const std::vector<std::string> shared{kInput, "models", "output", "map"};
  return shared;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// What `names` has of a map's entries.
void copyKnown(const YAML::Node& from, const std::vector<std::string>& keys,
               const std::vector<std::string>& names, YAML::Node& to) {
  for (const auto& key : keys) {
    if (contains(names, key) && from[key].IsDefined()) to[key] = from[key];
  }
}

void checkKeys(const Source& whole) {
  std::vector<std::string> known = listShared();
  known.insert(known.end(), listStages().begin(), listStages().end());
  std::vector<std::string> violations;
  std::set<std::string> seen;
  for (const auto& entry : whole.parameters) {
    const std::string key = formatNode(entry.first);
    if (!seen.insert(key).second) {
      violations.push_back("section '" + key + "' is there twice, expected once");
    }
    if (contains(known, key) || key == kRecordSection) continue;
    const std::string nearest = findNearestName(key, known);
    violations.push_back("unknown section '" + key + "'" +
                         (nearest.empty() ? "" : ", did you mean '" + nearest + "'?"));
  }
  internal::throwIfAny("configuration " + whole.name, violations);
}

}  // namespace

const std::vector<std::string>& listStages() {
  static const std::vector<std::string> stages{"segmenter", "tracker", "mesh_fusion",
                                               "scene_graph"};
  return stages;
}

Source readConfigFile(const std::filesystem::path& path) {
  if (path.empty()) return {};
  Source whole{"file '" + path.string() + "'", loadYamlFile(path.string()), path.parent_path()};
  if (whole.parameters.IsNull()) return whole;
  if (!whole.parameters.IsMap()) {
    throw ConfigError("configuration " + whole.name,
                      {"it is '" + formatNode(whole.parameters) +
                       "', expected a map with a section for each stage (tracker: {...})"});
  }
  checkKeys(whole);
  return whole;
}

Source pickShared(const Source& whole, const std::vector<std::string>& names) {
  Source shared{whole.name, YAML::Node(YAML::NodeType::Map), whole.folder};
  const YAML::Node& file = whole.parameters;
  if (!file.IsMap()) return shared;
  const YAML::Node input = file[kInput];
  if (!contains(names, kInput) && input.IsDefined() && input.IsMap()) {
    copyKnown(input, {kWorldFrame}, names, shared.parameters);
  }
  copyKnown(file, listShared(), names, shared.parameters);
  return shared;
}

std::vector<Source> splitConfig(const Source& whole, const std::string& stage,
                                const std::vector<std::string>& names) {
  if (!whole.parameters.IsMap()) return {};
  const YAML::Node& file = whole.parameters;
  return {pickShared(whole, names), {whole.name, file[stage], whole.folder}};
}

}  // namespace tsg::config
