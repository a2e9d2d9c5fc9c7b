// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "task_scene_graph/core/embedding.h"

namespace task_scene_graph::scene_graph {

/// The tasks in plain words (t_1 ... t_m of [Clio24, Sec. III]), in the order of their file.
struct TaskList {
  std::vector<std::string> names;
  EmbeddingMatrix embeddings;  ///< one row per name, or no row at all (names only)

  std::size_t size() const { return names.size(); }
  bool hasEmbeddings() const { return embeddings.rows() > 0; }

  /// Checks names (none empty, none twice) and embeddings (no row or one per name, finite, not
  /// zero). `where` says whose tasks they are, for instance "task file 'tasks.yaml'".
  /// @throws std::invalid_argument naming `where`, the task, its value and what was expected.
  void validate(const std::string& where) const;
};

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
/// @throws std::invalid_argument naming the file, the task, its value and what was expected, for
/// malformed YAML, duplicates, empty names, embeddings that are not finite or differ in size.
TaskList loadTasks(const std::string& path);

/// Writes the third kind of `loadTasks` (a plain list if there are no embeddings), safely (see
/// atomic_file.h). Embeddings keep every bit.
/// @throws std::runtime_error naming the path; std::invalid_argument if the tasks are not valid.
void writeTasks(const std::string& path, const TaskList& tasks);

/// Checks that tasks can be used together with a model set.
/// @param path              the task file, for the message
/// @param has_text_encoder  whether names alone are enough
/// @param embedding_size    size of the model set's embeddings; 0 = not known, any size will do
/// @throws std::invalid_argument if there are neither embeddings nor an encoder, or if the sizes
/// differ; the message names both.
void checkUsable(const TaskList& tasks, const std::string& path, bool has_text_encoder,
                 int embedding_size);

}  // namespace task_scene_graph::scene_graph
