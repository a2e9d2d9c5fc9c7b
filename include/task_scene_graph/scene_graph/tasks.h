// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "task_scene_graph/core/embedding.h"

namespace tsg::scene_graph {

/// The tasks in plain words (t_1 ... t_m of [Clio24, Sec. III]), in the order of their file.
struct TaskList {
  std::vector<std::string> names;
  EmbeddingMatrix embeddings;  ///< one row per name, or no row at all (names only)

  std::size_t size() const { return names.size(); }
  bool hasEmbeddings() const { return embeddings.rows() > 0; }

  /// Checks names (UTF-8, none empty, none twice, at most 1000 bytes) and embeddings (no row or one
  /// per name, finite, not zero). `where` says whose tasks they are, for instance "task file
  /// 'tasks.yaml'".
  /// @throws config::ConfigError with all violations, naming `where`, the task, its value and what
  /// was expected.
  void validate(const std::string& where) const;
};

bool operator==(const TaskList& a, const TaskList& b);

/// Checks that tasks can be clustered for: valid, with embeddings (unless there is no task).
/// @param embedding_size  size of the embeddings of what is clustered; 0 = any
/// @throws config::ConfigError naming `where` and both sizes.
void checkClusterable(const TaskList& tasks, const std::string& where, Eigen::Index embedding_size);

/// Reads a task file: YAML of one of three kinds, order kept.
///
///     wash the dishes: [...]            Clio's own: keys are the tasks; values (boxes) are ignored
///
///     - wash the dishes                 a plain list
///
///     tasks:                            names with ready embeddings (`embedding` may be absent in
///       - name: wash the dishes         all of them, not in some)
///         embedding: [0.1, ...]
///
/// A file with nothing in it is an empty list.
/// @throws config::ConfigError naming the file, the task, its value and what was expected, for a
/// missing file, malformed YAML, and (all of them at once) duplicates, names that are empty or not
/// UTF-8, unknown keys, embeddings that are not finite, all zero, or of different sizes.
TaskList loadTasks(const std::string& path);

/// Writes the third kind of `loadTasks` (without embeddings if there are none), whole or not
/// at all (core/files.h). Embeddings keep every bit.
/// @throws std::runtime_error naming the path; config::ConfigError if the tasks are not valid.
void writeTasks(const std::string& path, const TaskList& tasks);

/// Checks that tasks can be used together with a model set.
/// @param path              the task file, for the message
/// @param has_text_encoder  whether names alone are enough
/// @param embedding_size    size of the model set's embeddings; 0 = not known, any size will do
/// @throws config::ConfigError if there are neither embeddings nor an encoder, or if the sizes
/// differ; the message names both.
void checkUsable(const TaskList& tasks, const std::string& path, bool has_text_encoder,
                 int embedding_size);

}  // namespace tsg::scene_graph
