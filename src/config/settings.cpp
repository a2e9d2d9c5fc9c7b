// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/config/settings.h"

#include <algorithm>
#include <map>

namespace tsg::config {
namespace {

constexpr const char* kInputGroup = "input/";

struct SplitName {
  std::vector<std::string> groups;
  std::string name;
};

SplitName split(std::string name) {
  std::vector<std::string> groups;
  for (std::size_t slash = name.find('/'); slash != std::string::npos; slash = name.find('/')) {
    groups.push_back(name.substr(0, slash));
    name.erase(0, slash + 1);
  }
  return {groups, name};
}

bool isInput(const Setting& setting) { return setting.name.rfind(kInputGroup, 0) == 0; }

/// Values of the group `input` on which all stages that have it agree.
std::map<std::string, Setting> findSharedInput(const std::vector<StageSettings>& stages) {
  std::map<std::string, Setting> shared;
  std::map<std::string, bool> agree;
  for (const auto& stage : stages) {
    for (const auto& setting : stage.settings) {
      if (!isInput(setting)) continue;
      const auto [found, is_new] = shared.try_emplace(setting.name, setting);
      const bool is_same = is_new || found->second.value == setting.value;
      agree[setting.name] = (is_new || agree[setting.name]) && is_same;
    }
  }
  for (const auto& [name, is_shared] : agree) {
    if (!is_shared) shared.erase(name);
  }
  return shared;
}

YamlLine toLine(const std::string& section, const Setting& setting) {
  const bool is_default = setting.origin == kDefaultOrigin;
  return {section + setting.name, setting.value, is_default ? "" : setting.origin};
}

/// In the order in which the stages declare them, each once.
std::vector<YamlLine> listShared(const std::vector<StageSettings>& stages,
                                 std::map<std::string, Setting> shared) {
  std::vector<YamlLine> lines;
  for (const auto& stage : stages) {
    for (const auto& setting : stage.settings) {
      const auto found = shared.find(setting.name);
      if (found == shared.end()) continue;
      lines.push_back(toLine("", found->second));
      shared.erase(found);
    }
  }
  return lines;
}

}  // namespace

void writeYaml(std::ostream& stream, const std::vector<YamlLine>& lines) {
  std::vector<std::string> open;
  for (const auto& line : lines) {
    const SplitName split_name = split(line.name);
    const auto& groups = split_name.groups;
    std::size_t shared = 0;
    while (shared < std::min(groups.size(), open.size()) && groups[shared] == open[shared]) {
      ++shared;
    }
    for (std::size_t i = shared; i < groups.size(); ++i) {
      stream << std::string(2 * i, ' ') << groups[i] << ":\n";
    }
    open = groups;
    stream << std::string(2 * groups.size(), ' ') << split_name.name << ": " << line.value
           << (line.comment.empty() ? "" : "  # " + line.comment) << '\n';
  }
}

void writeSettings(std::ostream& stream, const std::vector<YamlLine>& record,
                   const std::vector<StageSettings>& stages) {
  stream << "# The parameters that were in force; a comment says where those that are no default"
            " came from.\n# To use them again: config:=, --config.\n";
  std::vector<YamlLine> lines = record;
  for (auto& line : lines) line.name = std::string(kRecordSection) + "/" + line.name;
  const auto shared = findSharedInput(stages);
  const auto input = listShared(stages, shared);
  lines.insert(lines.end(), input.begin(), input.end());
  for (const auto& stage : stages) {
    for (const auto& setting : stage.settings) {
      if (shared.count(setting.name) != 0 && isInput(setting)) continue;
      lines.push_back(toLine(stage.stage + "/", setting));
    }
  }
  writeYaml(stream, lines);
}

namespace internal {

std::string toYamlText(bool value) { return value ? "true" : "false"; }
std::string toYamlText(int value) { return std::to_string(value); }
std::string toYamlText(double value) { return formatExactly(value); }
std::string toYamlText(const std::string& value) { return quoteYaml(value); }
std::string toYamlText(const std::filesystem::path& value) { return quoteYaml(value.string()); }
std::string toYamlText(const NumbersOrPath& value) { return quoteYaml(value.text); }

void SettingLister::add(const std::string& name, const std::string& value) {
  const std::string path = joinPath(path_, name);
  const auto found = origins_.find(path);
  settings_.push_back({path, value, found == origins_.end() ? kDefaultOrigin : found->second});
}

}  // namespace internal
}  // namespace tsg::config
