// SPDX-License-Identifier: BSD-3-Clause
#include "node_attributes.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "json_fields.h"
#include "node_mesh.h"

namespace tsg::scene_graph {
namespace {

using nlohmann::json;

json readBoxField(const JsonText& text, const JsonObject& attributes) {
  return readFields(text, attributes, {"bounding_box"});
}

/// @param box  {"bounding_box": ...} of the merged node
void mergeMeshes(const JsonText& text, const std::vector<JsonObject>& members, const json& box,
                 FieldTexts& merged, std::vector<BadMesh>& bad_meshes) {
  NodeMesh sum;
  const JsonSpan* holder = members.front().find("mesh");  // gives the mesh its header and flags
  for (std::size_t i = 0; i < members.size(); ++i) {
    try {
      const MeshFrame frame = readMeshFrame(readBoxField(text, members[i]));
      NodeMesh mesh = readMesh(text, members[i], frame);
      if (mesh.points_m.empty()) continue;
      if (!sum.points_m.empty()) {
        appendMesh(mesh, sum);
        continue;
      }
      sum = std::move(mesh);
      if (sum.form == MeshForm::kNested) holder = members[i].find("mesh");
    } catch (const std::runtime_error& e) {
      bad_meshes.push_back({i, e.what()});
    }
  }
  // The first one's mesh must not stay where the box is another one now.
  const MeshFrame frame = readMeshFrame(box);
  const bool is_nested = sum.form == MeshForm::kNested;
  const NodeMesh none;
  if (holder != nullptr && text.isObject(*holder)) {
    merged.emplace_back(
        "mesh", writeNestedMesh(is_nested ? sum : none, frame, text, text.readObject(*holder)));
  }
  if (members.front().find("vertices") == nullptr) return;
  for (auto& field : writeFlatMesh(is_nested ? none : sum, frame)) {
    merged.push_back(std::move(field));
  }
}

/// Of two numbers; whole ones are compared as such, for a double does not hold all nanoseconds.
bool isLess(const JsonText& text, JsonSpan a, JsonSpan b) {
  const auto whole_a = text.readInteger(a);
  const auto whole_b = text.readInteger(b);
  return whole_a && whole_b ? *whole_a < *whole_b : *text.readNumber(a) < *text.readNumber(b);
}

// One interval from the first observation to the last.
void mergeTimes(const JsonText& text, const std::vector<JsonObject>& members, FieldTexts& merged) {
  const auto extend = [&](const char* name, bool is_latest) {
    const JsonSpan* form = members.front().find(name);
    if (form == nullptr) return;
    std::optional<JsonSpan> best;
    for (const JsonObject& member : members) {
      const JsonSpan* value = member.find(name);
      if (value == nullptr) continue;
      for (const JsonSpan time :
           text.isArray(*value) ? text.readArray(*value) : std::vector{*value}) {
        if (!text.readNumber(time)) continue;
        const bool is_better =
            !best || (is_latest ? isLess(text, *best, time) : isLess(text, time, *best));
        if (is_better) best = time;
      }
    }
    if (!best) return;
    merged.emplace_back(name,
                        text.isArray(*form) ? '[' + text.copy(*best) + ']' : text.copy(*best));
  };
  extend("first_observed_ns", false);
  extend("last_observed_ns", true);
  extend("last_update_time_ns", true);
}

/// Around the boxes that this package notes for each member; nothing unless each has one.
std::optional<OrientedBox> joinNotedBoxes(const JsonText& text,
                                          const std::vector<JsonObject>& members) {
  std::optional<Eigen::Vector3d> origin_m;
  std::vector<Eigen::Vector3f> corners_m;
  for (const JsonObject& member : members) {
    auto box = readNotedBox(readFields(text, member, {"metadata"}));
    if (!box || !box->center_m.allFinite()) return std::nullopt;
    // A float holds no millimetres at a map projection's coordinates.
    if (!origin_m) origin_m = box->center_m;
    box->center_m -= *origin_m;
    for (const Eigen::Vector3f& corner_m : box->corners()) corners_m.push_back(corner_m);
  }
  OrientedBox joined = computeOrientedBox(corners_m);
  joined.center_m += *origin_m;
  return joined;
}

/// What this package notes of a primitive does not hold for several; what others note stays.
void mergeMetadata(const JsonText& text, const std::vector<JsonObject>& members,
                   FieldTexts& merged) {
  json fields = readFields(text, members.front(), {"metadata"});
  const auto metadata = fields.find("metadata");
  if (metadata == fields.end() || !metadata->is_object()) return;
  std::size_t num_erased = 0;
  for (const char* of_one : {"track", "num_observations", "oriented_box"}) {
    num_erased += metadata->erase(of_one);
  }
  if (num_erased == 0) return;
  try {
    if (const auto box = joinNotedBoxes(text, members)) {
      (*metadata)["oriented_box"] = toNotedBox(*box);
    }
  } catch (const std::runtime_error&) {  // someone else's field of this name
  }
  merged.emplace_back("metadata", metadata->dump());
}

void mergeMeshConnections(const JsonText& text, const std::vector<JsonObject>& members,
                          FieldTexts& merged) {
  const JsonSpan* form = members.front().find("mesh_connections");
  if (form == nullptr || !text.isArray(*form)) return;
  std::string sum;
  for (const JsonObject& member : members) {
    const JsonSpan* list = member.find("mesh_connections");
    if (list == nullptr) continue;
    for (const JsonSpan entry : text.readArray(*list)) {
      sum += (sum.empty() ? "" : ",") + text.copy(entry);
    }
  }
  merged.emplace_back("mesh_connections", '[' + sum + ']');
}

std::int64_t readSize(const json& feature, const char* name) {
  const json& size = getField(feature, name);
  if (size.is_number_unsigned() && size > 0 && size < 1'000'000'000) {
    return size.get<std::int64_t>();
  }
  fail("has a 'semantic_feature' with " + std::string(name) + " = " + size.dump() +
       ", expected a whole number above 0");
}

/// Whatever form it has, or what is wrong with it.
Embedding readAnyFeature(const json& attributes) {
  const json& feature = getField(attributes, "semantic_feature");
  if (!feature.is_array() && !feature.is_object()) {
    failOn("semantic_feature", feature, "a list of numbers or a matrix");
  }
  const json& data = feature.is_array() ? feature : getField(feature, "data");
  if (!data.is_array() || data.empty()) fail("has an empty 'semantic_feature'");
  Embedding values(static_cast<Eigen::Index>(data.size()));
  for (std::size_t i = 0; i < data.size(); ++i) {
    if (!data[i].is_number()) {
      fail("has 'semantic_feature' entry " + std::to_string(i) + " = " + data[i].dump() +
           ", expected a number");
    }
    values[static_cast<Eigen::Index>(i)] = data[i].get<float>();
  }
  if (feature.is_object()) {
    const std::int64_t rows = readSize(feature, "rows");
    const std::int64_t cols = readSize(feature, "cols");
    if (rows * cols != values.size()) {
      fail("has a 'semantic_feature' of " + std::to_string(values.size()) + " entries, expected " +
           std::to_string(rows) + " x " + std::to_string(cols));
    }
    if (rows > 1 && cols > 1) {
      const Embedding mean =
          Eigen::Map<const EmbeddingMatrix>(values.data(), rows, cols).rowwise().mean();
      values = mean;
    }
  }
  return values;
}

/// A list of numbers, or a matrix of one column or row; nothing for anything else.
std::optional<Embedding> readPlainFeature(const JsonText& text, JsonSpan feature) {
  if (text.isArray(feature)) return text.readFloats(feature);
  const JsonObject matrix = text.readObject(feature);
  const JsonSpan* rows = matrix.find("rows");
  const JsonSpan* cols = matrix.find("cols");
  const JsonSpan* data = matrix.find("data");
  if (rows == nullptr || cols == nullptr || data == nullptr) return std::nullopt;
  const auto num_rows = text.readUnsigned(*rows);
  const auto num_cols = text.readUnsigned(*cols);
  if (num_rows != 1U && num_cols != 1U) return std::nullopt;
  auto values = text.readFloats(*data);
  const bool is_whole = values && num_rows && num_cols &&
                        static_cast<std::uint64_t>(values->size()) == *num_rows * *num_cols;
  return is_whole ? values : std::nullopt;
}

}  // namespace

Embedding readEmbedding(const JsonText& text, const JsonObject& attributes) {
  const JsonSpan* feature = attributes.find("semantic_feature");
  std::optional<Embedding> plain;
  if (feature != nullptr) plain = readPlainFeature(text, *feature);
  const bool is_plain = plain && plain->size() > 0;
  const Embedding values =
      is_plain ? *plain : readAnyFeature(readFields(text, attributes, {"semantic_feature"}));
  const double norm = values.cast<double>().norm();
  if (!std::isfinite(norm)) fail("has a 'semantic_feature' that is not finite");
  if (!(norm > 0.0)) fail("has a 'semantic_feature' of zeros");
  return values;
}

Eigen::Vector3d readPosition(const json& attributes) {
  const Eigen::Vector3d position = readVector(attributes, "position");
  if (!position.allFinite()) failOn("position", attributes.at("position"), "finite numbers");
  return position;
}

json readFields(const JsonText& text, const JsonObject& object,
                const std::vector<std::string>& names) {
  nlohmann::json fields = nlohmann::json::object();
  for (const std::string& name : names) {
    const JsonSpan* value = object.find(name);
    if (value != nullptr) fields[name] = nlohmann::json::parse(text.copy(*value));
  }
  return fields;
}

FieldTexts mergeAttributes(const JsonText& text, const std::vector<JsonObject>& members,
                           const Aabb& hull, const Eigen::Vector3d& position_m,
                           std::vector<BadMesh>& bad_meshes) {
  json box = readBoxField(text, members.front());
  box["bounding_box"] = replaceBox(box.at("bounding_box"), hull);
  FieldTexts merged = {{"bounding_box", box["bounding_box"].dump()},
                       {"position", toJson(position_m).dump()}};
  mergeTimes(text, members, merged);
  mergeMeshes(text, members, box, merged, bad_meshes);
  mergeMeshConnections(text, members, merged);
  mergeMetadata(text, members, merged);
  return merged;
}

}  // namespace tsg::scene_graph
