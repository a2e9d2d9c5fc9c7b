// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/prompts.h"

#include <stdexcept>

namespace tsg::language {
namespace {

const std::string& placeholder() {
  static const std::string text = kPlaceholder;
  return text;
}

int countPlaceholders(const std::string& text) {
  int count = 0;
  for (std::size_t at = 0; (at = text.find(placeholder(), at)) != std::string::npos; ++count) {
    at += placeholder().size();
  }
  return count;
}

}  // namespace

void checkTemplates(const std::vector<std::string>& templates) {
  if (templates.empty()) {
    throw std::invalid_argument("there is no prompt template, expected at least one, such as '{}'");
  }
  for (std::size_t i = 0; i < templates.size(); ++i) {
    const int count = countPlaceholders(templates[i]);
    if (count == 1) continue;
    throw std::invalid_argument("prompt template " + std::to_string(i + 1) + " '" + templates[i] +
                                "' has '{}' " + std::to_string(count) + " times, expected once");
  }
}

std::vector<std::string> fillTemplates(const std::vector<std::string>& names,
                                       const std::vector<std::string>& templates) {
  std::vector<std::string> prompts;
  for (const std::string& name : names) {
    for (const std::string& prompt_template : templates) {
      std::string prompt = prompt_template;
      prompts.push_back(prompt.replace(prompt.find(placeholder()), placeholder().size(), name));
    }
  }
  return prompts;
}

EmbeddingMatrix normalizeRows(EmbeddingMatrix embeddings) {
  // Not rowwise().normalize(), which makes a row of zeros NaN.
  for (Eigen::Index i = 0; i < embeddings.rows(); ++i) embeddings.row(i).normalize();
  return embeddings;
}

EmbeddingMatrix averageGroups(const EmbeddingMatrix& embeddings, int group_size) {
  if (group_size < 1 || embeddings.rows() % group_size != 0) {
    throw std::invalid_argument(std::to_string(embeddings.rows()) +
                                " embeddings cannot be divided in groups of " +
                                std::to_string(group_size));
  }
  const EmbeddingMatrix units = normalizeRows(embeddings);
  EmbeddingMatrix means(embeddings.rows() / group_size, embeddings.cols());
  for (Eigen::Index i = 0; i < means.rows(); ++i) {
    means.row(i) = units.middleRows(i * group_size, group_size).colwise().mean();
  }
  return normalizeRows(std::move(means));
}

}  // namespace tsg::language
