// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/model_set.h"

#include <filesystem>

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
  if (!fs::is_regular_file(file)) {
    violations.push_back(std::string("'") + key + "': file '" + file + "' is not there");
  }
}

void requireThree(const char* key, const std::vector<double>& values,
                  std::vector<std::string>& violations) {
  if (values.size() == 3) return;
  violations.push_back(std::string("'") + key + "' has " + std::to_string(values.size()) +
                       " numbers, expected 3 (red, green, blue)");
}

}  // namespace

ModelSet loadModelSet(const std::string& yaml_path) {
  const fs::path path = expandPath(yaml_path);
  const std::string where = "model set '" + path.string() + "'";
  auto models = config::load<ModelSet>(config::loadYamlFile(path.string()), where);
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

}  // namespace tsg::segmentation
