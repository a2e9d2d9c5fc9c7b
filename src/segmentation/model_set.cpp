// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/model_set.h"

#include <filesystem>

#include "task_scene_graph/config/config.h"

namespace tsg::segmentation {
namespace {
namespace fs = std::filesystem;

void resolveFile(const fs::path& folder, const char* key, bool required, std::string& file,
                 std::vector<std::string>& violations) {
  if (file.empty()) {
    if (required) violations.push_back(std::string("'") + key + "' names no file");
    return;
  }
  file = (folder / file).lexically_normal().string();  // an absolute path stays as it is
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
  const std::string where = "model set '" + yaml_path + "'";
  auto models = config::load<ModelSet>(config::loadYamlFile(yaml_path), where);
  std::vector<std::string> violations;
  const fs::path folder = fs::path(yaml_path).parent_path();
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
