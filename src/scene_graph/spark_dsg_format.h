// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "json_text.h"
#include "task_scene_graph/core/embedding.h"

/// What all that writes spark_dsg's JSON has in common: ids, edges, embeddings, objects that are
/// another with some fields replaced. Text is appended, in the shortest form that reads the same.
namespace tsg::scene_graph {

/// A node's id: a letter in the top byte, a number below it.
constexpr std::uint64_t makeNodeId(char letter, std::uint64_t index) {
  return (static_cast<std::uint64_t>(letter) << 56U) | index;
}

/// `weight` counts where `is_weighted`; from version 1.1 on readers want `metadata`.
struct EdgeInfo {
  double weight = 1.0;
  bool is_weighted = false;
  bool has_metadata = false;
};
void appendEdge(std::uint64_t source, std::uint64_t target, const EdgeInfo& info,
                std::string& text);

/// How `semantic_feature` is written: as a list, or as a matrix of one column or row.
enum class FeatureForm { kList, kColumn, kRow };
void appendFeature(const Embedding& embedding, FeatureForm form, std::string& text);

/// A string in quotes. Bytes that are not UTF-8 are replaced.
std::string quoteJson(const std::string& text);

/// Names and JSON texts of fields.
using FieldTexts = std::vector<std::pair<std::string, std::string>>;

/// In the place of a value: the object is to be without the field.
constexpr const char* kNoField = "";

/// An object of the file with the values of some fields replaced; those it has not are appended.
std::string replaceFields(const JsonText& json, const JsonObject& object, const FieldTexts& fields);

}  // namespace tsg::scene_graph
