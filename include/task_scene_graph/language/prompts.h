// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/core/embedding.h"

namespace tsg::language {

/// What stands for the task in a prompt template, as in "an image of {}".
constexpr const char* kPlaceholder = "{}";

/// @throws std::invalid_argument naming the template and its number if there is none, or one that
/// has the placeholder not exactly once.
void checkTemplates(const std::vector<std::string>& templates);

/// The prompts of each name in turn: prompt i * templates + j is name i in template j.
std::vector<std::string> fillTemplates(const std::vector<std::string>& names,
                                       const std::vector<std::string>& templates);

/// Rows of length 1; a row of zeros stays.
EmbeddingMatrix normalizeRows(EmbeddingMatrix embeddings);

/// One row for each run of `group_size` rows: the mean of the rows brought to length 1, itself
/// brought to length 1 (CLIP's prompt ensembling).
/// @throws std::invalid_argument if the rows cannot be divided so.
EmbeddingMatrix averageGroups(const EmbeddingMatrix& embeddings, int group_size);

}  // namespace tsg::language
