// SPDX-License-Identifier: BSD-3-Clause
#include "spark_dsg_format.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "json_numbers.h"

namespace tsg::scene_graph {

void appendEdge(std::uint64_t source, std::uint64_t target, const EdgeInfo& info,
                std::string& text) {
  text += "{\"source\":" + std::to_string(source) + ",\"target\":" + std::to_string(target) +
          ",\"info\":{\"type\":\"EdgeAttributes\",\"weighted\":" +
          (info.is_weighted ? "true" : "false") + ",\"weight\":";
  appendNumber(info.weight, text);
  text += info.has_metadata ? ",\"metadata\":{}}}" : "}}";
}

void appendFeature(const Embedding& embedding, FeatureForm form, std::string& text) {
  const std::string size = std::to_string(embedding.size());
  if (form == FeatureForm::kColumn) text += "{\"rows\":" + size + ",\"cols\":1,\"data\":";
  if (form == FeatureForm::kRow) text += "{\"rows\":1,\"cols\":" + size + ",\"data\":";
  appendNumbers(embedding, text);
  if (form != FeatureForm::kList) text += '}';
}

std::string quoteJson(const std::string& text) {
  using Json = nlohmann::json;
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string replaceFields(const JsonText& json, const JsonObject& object,
                          const FieldTexts& fields) {
  std::string text = "{";
  const auto add = [&](const std::string& key, const std::string& value) {
    if (value == kNoField) return;
    text += (text.size() > 1 ? "," : "") + quoteJson(key) + ':' + value;
  };
  for (const JsonField& field : object.fields()) {
    const auto replaced = std::find_if(fields.begin(), fields.end(),
                                       [&](const auto& f) { return f.first == field.key; });
    add(field.key, replaced == fields.end() ? json.copy(field.value) : replaced->second);
  }
  for (const auto& [key, value] : fields) {
    if (object.find(key) == nullptr) add(key, value);
  }
  return text + '}';
}

}  // namespace tsg::scene_graph
