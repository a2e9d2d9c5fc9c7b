// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/map/settings.h"

namespace tsg::map {

std::filesystem::path findModels(const std::filesystem::path& folder) {
  const std::filesystem::path file = locateFile(folder, "settings.yaml");
  if (!std::filesystem::exists(file)) return {};
  const config::Source whole = config::readConfigFile(file);
  const YAML::Node section = whole.parameters["scene_graph"];
  const YAML::Node models = section.IsMap() ? section["models"] : YAML::Node();
  if (!models.IsScalar() || models.Scalar().empty()) return {};
  const std::filesystem::path path = whole.folder / models.Scalar();
  return std::filesystem::exists(path) ? path : std::filesystem::path();
}

}  // namespace tsg::map
