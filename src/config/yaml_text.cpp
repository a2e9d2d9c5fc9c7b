// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/config/yaml_text.h"

#include <sstream>

namespace tsg::config {

std::string endLine(std::string yaml) {
  if (!yaml.empty() && yaml.back() != '\n') yaml += '\n';
  return yaml;
}

std::string findEndlessBrackets(const std::string& yaml) {
  std::istringstream lines(yaml);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    const std::size_t opened = line.find_first_of("[{");
    if (opened == std::string::npos || line.find(":]", opened) == std::string::npos) continue;
    return "line " + std::to_string(number) +
           ": ':]' in brackets, expected a value between the colon and the bracket, or a space";
  }
  return "";
}

}  // namespace tsg::config
