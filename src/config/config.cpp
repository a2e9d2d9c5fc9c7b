// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/config/config.h"

#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <sstream>

#include "task_scene_graph/config/yaml_text.h"
#include "task_scene_graph/core/files.h"

namespace tsg::config {
namespace {

std::string joinLines(const std::string& where, const std::vector<std::string>& violations) {
  std::string text = where + ":";
  for (const auto& violation : violations) text += "\n  " + violation;
  return text;
}

class EventIgnorer : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

/// YAML::LoadAll never ends where a document begins with a comma: it finds one more document in
/// front of it, again and again.
bool hasSecondDocument(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  EventIgnorer ignorer;
  return parser.HandleNextDocument(ignorer) && parser.HandleNextDocument(ignorer);
}

std::string readText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

constexpr int kMaxDepth = 100;

/// An alias may stand for more than a file holds: `a: &a [*a]` has no end, and ten lines that name
/// the one before ten times each stand for 10^10 values.
/// @param num_left  values that the file may still stand for
void checkSize(const YAML::Node& node, int depth, std::size_t& num_left, const std::string& where) {
  if (depth > kMaxDepth) {
    throw ConfigError(where, {"it is nested deeper than " + std::to_string(kMaxDepth) +
                              " levels, or holds an alias (*) of what it lies in"});
  }
  if (num_left-- == 0) {
    throw ConfigError(where, {"its aliases (*) stand for many times the values that it holds"});
  }
  for (const auto& child : node) {
    if (node.IsMap()) {
      checkSize(child.first, depth + 1, num_left, where);
      checkSize(child.second, depth + 1, num_left, where);
    } else {
      checkSize(child, depth + 1, num_left, where);
    }
  }
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

ConfigError::ConfigError(const std::string& problem) : std::runtime_error(problem) {}

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
  const std::string where = "YAML file '" + std::filesystem::absolute(path).string() + "'";
  try {
    requireFile("YAML file", path);
  } catch (const std::runtime_error& e) {
    throw ConfigError(e.what());
  }
  try {
    const std::string text = endLine(readText(path));
    const std::string endless = findEndlessBrackets(text);
    if (!endless.empty()) throw ConfigError(where, {endless});
    if (hasSecondDocument(text)) {
      throw ConfigError(where,
                        {"there are 2 documents in it or more, expected one: lines '---', or a "
                         "comma or bracket where none belongs"});
    }
    const YAML::Node root = YAML::Load(text);
    std::size_t num_left = 1000 + 10 * text.size();  // without aliases, a value takes a byte
    checkSize(root, 0, num_left, where);
    return root;
  } catch (const YAML::Exception& e) {
    const std::string line =
        e.mark.is_null() ? "" : "line " + std::to_string(e.mark.line + 1) + ": ";
    throw ConfigError(where, {line + "not YAML: " + e.msg});
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

std::string toChoiceName(std::string text) {
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}

bool read(const YAML::Node& node, bool& value) {
  const auto parsed = node.IsScalar() ? parseBool(node.Scalar()) : std::nullopt;
  value = parsed.value_or(value);
  return parsed.has_value();
}

bool read(const YAML::Node& node, int& value) {
  const auto parsed = node.IsScalar() ? parseInteger(node.Scalar()) : std::nullopt;
  value = parsed.value_or(value);
  return parsed.has_value();
}

bool read(const YAML::Node& node, double& value) {
  const auto parsed = node.IsScalar() ? parseNumber(node.Scalar()) : std::nullopt;
  value = parsed.value_or(value);
  return parsed.has_value();
}

bool read(const YAML::Node& node, std::string& value) {
  if (!node.IsScalar() || !describeTyped(node).empty()) return false;
  value = node.Scalar();
  return true;
}

std::string mention(const std::string& source) { return source.empty() ? "" : " (" + source + ")"; }

Loader::Loader(const Source& source, std::vector<std::string>& violations, Origins* origins)
    : source_(source), map_(source.parameters), violations_(violations), origins_(origins) {
  checkIsMap();
}

Loader::Loader(const Loader& parent, const YAML::Node& map, const std::string& group)
    : source_(parent.source_),
      map_(map),
      path_(joinPath(parent.path_, group)),
      violations_(parent.violations_),
      origins_(parent.origins_) {
  checkIsMap();
}

void Loader::checkIsMap() {
  if (!map_.IsDefined() || map_.IsNull() || map_.IsMap()) return;
  report((path_.empty() ? "the configuration" : path_) + " is not a map of parameters");
}

void Loader::report(const std::string& problem) const {
  violations_.push_back(problem + mention(source_.name));
}

YAML::Node Loader::consume(const std::string& name) {
  known_.insert(name);
  if (!map_.IsDefined() || !map_.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
  return const_cast<const YAML::Node&>(map_)[name];
}

void Loader::noteOrigin(const std::string& name) {
  if (origins_ != nullptr) (*origins_)[joinPath(path_, name)] = source_.name;
}

void Loader::field(const char* name, std::filesystem::path& value, Range, const char*,
                   const char*) {
  const YAML::Node node = consume(name);
  if (!node.IsDefined()) return;
  std::string text;
  if (!read(node, text)) return wrongType(name, node, TypeName<std::filesystem::path>::value);
  const auto path = expand(name, text);
  if (!path) return;
  value = *path;
  noteOrigin(name);
}

void Loader::field(const char* name, NumbersOrPath& value, Range, const char*, const char*) {
  const YAML::Node node = consume(name);
  if (!node.IsDefined()) return;
  std::string text;
  if (!read(node, text)) return wrongType(name, node, TypeName<NumbersOrPath>::value);
  if (!parseNumbers(text)) {
    const auto path = expand(name, text);
    if (!path) return;
    text = path->string();
  }
  value.text = text;
  noteOrigin(name);
}

std::optional<std::filesystem::path> Loader::expand(const std::string& name,
                                                    const std::string& text) {
  try {
    return expandPath(text, source_.folder);
  } catch (const std::invalid_argument& e) {
    report("parameter '" + joinPath(path_, name) + "': " + e.what());
    return std::nullopt;
  }
}

void Loader::wrongType(const std::string& name, const YAML::Node& node,
                       const std::string& expected) {
  const std::string parameter = "parameter '" + joinPath(path_, name) + "'";
  if (node.IsNull()) {
    report(parameter + " is empty, expected " + expected + "; for the default, remove it");
    return;
  }
  const bool is_text = expected == TypeName<std::string>::value ||
                       expected == TypeName<std::filesystem::path>::value ||
                       expected == TypeName<NumbersOrPath>::value;
  const std::string typed = is_text && node.IsScalar() ? describeTyped(node) : "";
  if (!typed.empty()) {
    report(parameter + " is " + typed + ", expected " + expected +
           ": put it in quotes (as `<param>`: type=\"str\")");
    return;
  }
  const std::string value = formatNode(node);
  const std::string hint = node.IsScalar() ? explainNumber(value) : "";
  report(parameter + " is '" + value + "', expected " + expected + hint);
}

void Loader::finish() const {
  if (!map_.IsDefined() || !map_.IsMap()) return;
  std::set<std::string> seen;
  for (const auto& entry : map_) {
    const std::string key = formatNode(entry.first);
    const std::string parameter = "parameter '" + joinPath(path_, key) + "'";
    if (!seen.insert(key).second) report(parameter + " is there twice, expected once");
    if (known_.count(key) != 0) continue;
    const std::string nearest = findNearestName(key, {known_.begin(), known_.end()});
    report("unknown " + parameter + (nearest.empty() ? "" : ", did you mean '" + nearest + "'?"));
  }
}

void Checker::check(const std::string& name, double value, Range range, const std::string& unit) {
  if (value >= range.min && value <= range.max) return;
  const std::string path = joinPath(path_, name);
  const bool is_given = origins_ != nullptr && origins_->count(path) != 0;
  violations_.push_back("parameter '" + path + "' is " + formatNumber(value) +
                        ", expected a value in " + formatRange(range) +
                        (unit.empty() ? "" : " " + unit) +
                        (is_given ? mention(origins_->at(path)) : ""));
}

void throwIfAny(const std::string& where, const std::vector<std::string>& violations) {
  if (!violations.empty()) throw ConfigError(where, violations);
}

}  // namespace internal
}  // namespace tsg::config
