// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "task_scene_graph/config/config_file.h"
#include "task_scene_graph/map/folder.h"

/// What a map was made with, out of its `settings.yaml`.
namespace tsg::map {

/// A group of one stage's settings; the defaults where the map has no such file or group.
/// @param group  for example "planner" of "mesh_fusion"
/// @throws config::ConfigError naming the file and what is wrong with it.
template <typename Config>
Config readSettings(const std::filesystem::path& folder, const std::string& stage,
                    const std::string& group) {
  const std::filesystem::path file = locateFile(folder, "settings.yaml");
  if (!std::filesystem::exists(file)) return {};
  const config::Source whole = config::readConfigFile(file);
  const YAML::Node section = whole.parameters[stage];
  if (!section.IsMap() || !section[group].IsMap()) return {};
  return config::load<Config>({{whole.name, section[group], whole.folder}},
                              whole.name + ", " + stage + "/" + group);
}

/// The model set's file that a map was made with; empty if it says none, or that is no more there.
std::filesystem::path findModels(const std::filesystem::path& folder);

}  // namespace tsg::map
