// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/model_set.h"

#include <filesystem>
#include <set>
#include <system_error>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/files.h"

namespace tsg::segmentation {
namespace {
namespace fs = std::filesystem;

void resolveFile(const fs::path& folder, const char* key, bool required, std::string& file,
                 std::vector<std::string>& violations) {
  if (file.empty()) {
    if (required) violations.push_back(std::string("'") + key + "' names no file");
    return;
  }
  try {
    file = expandPath(file, folder).string();
  } catch (const std::invalid_argument& e) {
    violations.push_back(std::string("'") + key + "': " + e.what());
    return;
  }
  std::error_code ignored;
  if (fs::is_regular_file(file, ignored)) return;
  const bool is_folder = fs::is_directory(file, ignored);
  violations.push_back(std::string("'") + key + "': file '" + file +
                       (is_folder ? "' is a folder" : "' is not there"));
}

void requireThree(const char* key, const std::vector<double>& values,
                  std::vector<std::string>& violations) {
  if (values.size() == 3) return;
  violations.push_back(std::string("'") + key + "' has " + std::to_string(values.size()) +
                       " numbers, expected 3 (red, green, blue)");
}

/// YAML readers take one of them without a word.
void requireDifferentKeys(const YAML::Node& map, const std::string& where) {
  if (!map.IsMap()) return;
  std::set<std::string> keys;
  for (const auto& entry : map) {
    const auto key = entry.first.as<std::string>();
    if (!keys.insert(key).second)
      throw config::ConfigError(where, {"'" + key + "' is there twice"});
  }
}

ModelSet readKeys(const std::string& path, const std::string& where) {
  try {
    const YAML::Node map = config::loadYamlFile(path);
    requireDifferentKeys(map, where);
    return config::load<ModelSet>(map, where);
  } catch (const YAML::Exception& e) {  // keys that are no words, for instance
    throw config::ConfigError(where, {e.what()});
  }
}

}  // namespace

ModelSet loadModelSet(const std::string& yaml_path) {
  const fs::path path = expandPath(yaml_path);
  const std::string where = "model set '" + path.string() + "'";
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw config::ConfigError(where, {"the file is not there"});
  if (fs::is_directory(path, ignored)) {
    throw config::ConfigError(where, {"it is a folder; expected a model set's YAML file"});
  }
  ModelSet models = readKeys(path.string(), where);
  models.file = path.string();
  std::vector<std::string> violations;
  const fs::path folder = path.parent_path();
  resolveFile(folder, "segmenter", true, models.segmenter, violations);
  resolveFile(folder, "image_encoder", true, models.image_encoder, violations);
  resolveFile(folder, "text_encoder", false, models.text_encoder, violations);
  resolveFile(folder, "tokenizer", false, models.tokenizer, violations);
  requireThree("image_mean", models.image_mean, violations);
  requireThree("image_std", models.image_std, violations);
  if (!violations.empty()) throw config::ConfigError(where, violations);
  return models;
}

std::string describe(const ModelSet& models) {
  return "model set '" + models.name + "'" + (models.file.empty() ? "" : " (" + models.file + ")");
}

}  // namespace tsg::segmentation
