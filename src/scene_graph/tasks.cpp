// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/tasks.h"

#include <yaml-cpp/yaml.h>

#include <limits>
#include <set>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/core/utf8.h"

namespace tsg::scene_graph {
namespace {

using Violations = std::vector<std::string>;

constexpr std::size_t kMaxNameBytes = 1000;

std::string quote(const std::string& text) { return "'" + text + "'"; }

std::string describeTask(const TaskList& tasks, std::size_t i) {
  return "task " + std::to_string(i + 1) + " " + quote(tasks.names[i]);
}

bool isBlank(const std::string& text) {
  return text.find_first_not_of(" \t\r\n") == std::string::npos;
}

void checkNames(const TaskList& tasks, Violations& violations) {
  std::set<std::string> seen;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    if (!isValidUtf8(tasks.names[i])) {
      violations.push_back("task " + std::to_string(i + 1) +
                           ": the name is not valid UTF-8; convert the file to UTF-8");
    } else if (tasks.names[i].size() > kMaxNameBytes) {
      violations.push_back("task " + std::to_string(i + 1) + " '" + tasks.names[i].substr(0, 40) +
                           "...': a name of " + std::to_string(tasks.names[i].size()) +
                           " bytes, expected at most " + std::to_string(kMaxNameBytes) +
                           ": text encoders read 77 tokens");
    } else if (isBlank(tasks.names[i])) {
      violations.push_back(describeTask(tasks, i) + " is empty, expected a name in words");
    } else if (!seen.insert(tasks.names[i]).second) {
      violations.push_back(describeTask(tasks, i) + " is there twice, expected different tasks");
    }
  }
}

void checkEmbeddings(const TaskList& tasks, Violations& violations) {
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const auto row = tasks.embeddings.row(static_cast<Eigen::Index>(i));
    if (!row.allFinite()) {
      violations.push_back(describeTask(tasks, i) +
                           ": the embedding holds a NaN or infinite value, expected finite ones");
    } else if (row.isZero(0.0F)) {
      violations.push_back(describeTask(tasks, i) +
                           ": the embedding is all zeros, expected a direction");
    }
  }
}

/// Names and embeddings of one file while it is read: rows may still differ in size.
struct Draft {
  std::vector<std::string> names;
  std::vector<std::vector<float>> rows;  ///< one per name, empty = none given
  Violations violations;
};

std::string toName(const YAML::Node& node) { return node.IsScalar() ? node.Scalar() : ""; }

std::vector<float> readRow(const YAML::Node& node, const std::string& task, Violations& errors) {
  std::vector<float> row;
  if (!node.IsSequence() || node.size() == 0) {
    errors.push_back("task " + quote(task) + ": embedding is '" + YAML::Dump(node) +
                     "', expected a list of numbers");
    return row;
  }
  for (const auto& value : node) {
    float number = 0.0F;
    if (!value.IsScalar() || !YAML::convert<float>::decode(value, number)) {
      errors.push_back("task " + quote(task) + ": embedding value " +
                       std::to_string(row.size() + 1) + " is '" + YAML::Dump(value) +
                       "', expected a number");
      number = 1.0F;
    }
    row.push_back(number);
  }
  return row;
}

void readEntry(const YAML::Node& entry, Draft& draft) {
  std::string name = toName(entry);
  std::vector<float> row;
  if (entry.IsMap()) {
    name = entry["name"] ? toName(entry["name"]) : "";
    for (const auto& field : entry) {
      const std::string key = toName(field.first);
      if (key == "name" || key == "embedding") continue;
      draft.violations.push_back("task " + std::to_string(draft.names.size() + 1) +
                                 ": unknown key " + quote(key) +
                                 ", expected 'name' or 'embedding'");
    }
    if (entry["embedding"]) row = readRow(entry["embedding"], name, draft.violations);
  }
  draft.names.push_back(name);
  draft.rows.push_back(row);
}

/// True for `tasks: [...]`, false for a file of Clio's own kind, which is a map of tasks to boxes.
bool hasTaskKey(const YAML::Node& root) {
  return root.size() == 1 && toName(root.begin()->first) == "tasks" &&
         (root["tasks"].IsSequence() || root["tasks"].IsNull());
}

void readRoot(const YAML::Node& root, Draft& draft) {
  if (root.IsNull()) return;
  if (root.IsMap() && !hasTaskKey(root)) {
    for (const auto& entry : root) draft.names.push_back(toName(entry.first));
    draft.rows.resize(draft.names.size());
  } else if (root.IsMap() || root.IsSequence()) {
    const YAML::Node list = root.IsMap() ? root["tasks"] : root;
    for (const auto& entry : list) readEntry(entry, draft);
  } else {
    draft.violations.push_back("the file is '" + YAML::Dump(root) +
                               "', expected a list of tasks or a map of which the keys are tasks");
  }
}

/// Copies the rows where all of them have one size, else reports those that differ from the first.
EmbeddingMatrix joinRows(Draft& draft) {
  std::size_t first = 0;
  while (first < draft.rows.size() && draft.rows[first].empty()) ++first;
  if (first == draft.rows.size()) return {};
  const std::size_t columns = draft.rows[first].size();
  EmbeddingMatrix matrix = EmbeddingMatrix::Ones(static_cast<Eigen::Index>(draft.rows.size()),
                                                 static_cast<Eigen::Index>(columns));
  for (std::size_t i = 0; i < draft.rows.size(); ++i) {
    const auto& row = draft.rows[i];
    if (row.size() != columns) {
      draft.violations.push_back("task " + quote(draft.names[i]) + ": the embedding has " +
                                 std::to_string(row.size()) + " values, expected " +
                                 std::to_string(columns) + " as in task " +
                                 quote(draft.names[first]));
      continue;
    }
    matrix.row(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::RowVectorXf>(row.data(), static_cast<Eigen::Index>(columns));
  }
  return matrix;
}

void emitTask(YAML::Emitter& out, const TaskList& tasks, std::size_t i) {
  out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted
      << tasks.names[i];
  if (tasks.hasEmbeddings()) {
    out << YAML::Key << "embedding" << YAML::Value << YAML::Flow << YAML::BeginSeq;
    const auto row = tasks.embeddings.row(static_cast<Eigen::Index>(i));
    for (Eigen::Index d = 0; d < row.size(); ++d) out << row[d];
    out << YAML::EndSeq;
  }
  out << YAML::EndMap;
}

Violations findViolations(const TaskList& tasks) {
  Violations violations;
  checkNames(tasks, violations);
  if (!tasks.hasEmbeddings()) return violations;
  if (static_cast<std::size_t>(tasks.embeddings.rows()) != tasks.size()) {
    violations.push_back("there are " + std::to_string(tasks.embeddings.rows()) +
                         " embeddings, expected one for each of the " +
                         std::to_string(tasks.size()) + " tasks");
    return violations;
  }
  checkEmbeddings(tasks, violations);
  return violations;
}

}  // namespace

void TaskList::validate(const std::string& where) const {
  config::internal::throwIfAny(where, findViolations(*this));
}

bool operator==(const TaskList& a, const TaskList& b) {
  return a.names == b.names && a.embeddings.rows() == b.embeddings.rows() &&
         a.embeddings.cols() == b.embeddings.cols() && a.embeddings == b.embeddings;
}

void checkClusterable(const TaskList& tasks, const std::string& where,
                      Eigen::Index embedding_size) {
  tasks.validate(where);
  if (tasks.size() == 0) return;
  const Eigen::Index size = tasks.embeddings.cols();
  if (!tasks.hasEmbeddings()) {
    throw config::ConfigError(where, {"there are names only, expected an embedding for each"});
  }
  if (embedding_size == 0 || size == embedding_size) return;
  throw config::ConfigError(where,
                            {"the embeddings have " + std::to_string(size) + " values, expected " +
                             std::to_string(embedding_size) + " as what is to be clustered has"});
}

TaskList loadTasks(const std::string& path) {
  const std::string full_path = expandPath(path).string();
  const std::string where = "task file " + quote(full_path);
  Draft draft;
  readRoot(config::loadYamlFile(full_path), draft);
  TaskList tasks;
  tasks.names = draft.names;
  tasks.embeddings = joinRows(draft);
  for (const auto& violation : findViolations(tasks)) draft.violations.push_back(violation);
  config::internal::throwIfAny(where, draft.violations);
  return tasks;
}

void writeTasks(const std::string& path, const TaskList& tasks) {
  tasks.validate("tasks for " + quote(path));
  YAML::Emitter out;
  out.SetFloatPrecision(std::numeric_limits<float>::max_digits10);
  out << YAML::BeginMap << YAML::Key << "tasks" << YAML::Value << YAML::BeginSeq;
  for (std::size_t i = 0; i < tasks.size(); ++i) emitTask(out, tasks, i);
  out << YAML::EndSeq << YAML::EndMap;
  writeFileAtomically(path, [&](std::ostream& stream) { stream << out.c_str() << '\n'; });
}

void checkUsable(const TaskList& tasks, const std::string& path, bool has_text_encoder,
                 int embedding_size) {
  const std::string where = "task file " + quote(path);
  if (tasks.size() == 0) return;
  if (!tasks.hasEmbeddings()) {
    if (has_text_encoder) return;
    throw config::ConfigError(
        where, {"the file gives no embeddings and the model set has no text encoder; expected "
                "'tasks: [{name: ..., embedding: [...]}]' or a model set with 'text_encoder'"});
  }
  if (embedding_size == 0 || tasks.embeddings.cols() == embedding_size) return;
  throw config::ConfigError(
      where,
      {"the embeddings have " + std::to_string(tasks.embeddings.cols()) + " values, expected " +
       std::to_string(embedding_size) + " as the model set's embeddings have"});
}

}  // namespace tsg::scene_graph
