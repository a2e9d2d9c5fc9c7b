// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/config/config.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

namespace tsg::config {
namespace {

std::string joinLines(const std::string& where, const std::vector<std::string>& violations) {
  std::string text = where + ":";
  for (const auto& violation : violations) text += "\n  " + violation;
  return text;
}

std::size_t computeEditDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

ConfigError::ConfigError(const std::string& where, const std::vector<std::string>& violations)
    : std::runtime_error(joinLines(where, violations)) {}

std::string findNearestName(const std::string& name, const std::vector<std::string>& candidates) {
  std::string nearest;
  std::size_t best = std::max<std::size_t>(2, name.size() / 3) + 1;
  for (const auto& candidate : candidates) {
    const std::size_t distance = computeEditDistance(name, candidate);
    if (distance >= best) continue;
    best = distance;
    nearest = candidate;
  }
  return nearest;
}

YAML::Node loadYamlFile(const std::string& path) {
  try {
    return YAML::LoadFile(path);
  } catch (const YAML::Exception& e) {
    throw ConfigError("YAML file '" + path + "'", {e.what()});
  }
}

namespace internal {

std::string formatNumber(double value) {
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  std::ostringstream text;
  text << value;
  return text.str();
}

std::string formatRange(Range range) {
  if (std::isinf(range.min) && std::isinf(range.max)) return "";
  return "[" + formatNumber(range.min) + ", " + formatNumber(range.max) + "]";
}

std::string joinPath(const std::string& path, const std::string& name) {
  return path.empty() ? name : path + "/" + name;
}

Loader::Loader(const YAML::Node& map, std::string path, std::vector<std::string>& violations)
    : map_(map), path_(std::move(path)), violations_(violations) {
  if (!map_.IsDefined() || map_.IsNull() || map_.IsMap()) return;
  violations_.push_back((path_.empty() ? "the configuration" : path_) +
                        " is not a map of parameters");
}

YAML::Node Loader::take(const std::string& name) {
  known_.insert(name);
  if (!map_.IsDefined() || !map_.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
  return const_cast<const YAML::Node&>(map_)[name];
}

void Loader::wrongType(const std::string& name, const YAML::Node& node,
                       const std::string& expected) {
  const std::string value = node.IsScalar() ? node.Scalar() : YAML::Dump(node);
  violations_.push_back("parameter '" + joinPath(path_, name) + "' is '" + value + "', expected " +
                        expected);
}

void Loader::finish() const {
  if (!map_.IsDefined() || !map_.IsMap()) return;
  for (const auto& entry : map_) {
    const std::string key = entry.first.as<std::string>();
    if (known_.count(key) != 0) continue;
    const std::string nearest = findNearestName(key, {known_.begin(), known_.end()});
    violations_.push_back("unknown parameter '" + joinPath(path_, key) + "'" +
                          (nearest.empty() ? "" : ", did you mean '" + nearest + "'?"));
  }
}

void Checker::check(const std::string& name, double value, Range range, const std::string& unit) {
  if (value >= range.min && value <= range.max) return;
  violations_.push_back("parameter '" + joinPath(path_, name) + "' is " + formatNumber(value) +
                        ", expected a value in " + formatRange(range) +
                        (unit.empty() ? "" : " " + unit));
}

void throwIfAny(const std::string& where, const std::vector<std::string>& violations) {
  if (!violations.empty()) throw ConfigError(where, violations);
}

}  // namespace internal
}  // namespace tsg::config
