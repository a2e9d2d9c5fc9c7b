// SPDX-License-Identifier: BSD-3-Clause
#include "node_attributes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "json_fields.h"
#include "node_mesh.h"

namespace tsg::bottleneck {
namespace {

using nlohmann::json;

json mergeEmbeddings(const std::vector<const json*>& members) {
  Eigen::VectorXd sum = readEmbedding(*members.front()).cast<double>();
  for (std::size_t i = 1; i < members.size(); ++i) {
    sum += readEmbedding(*members[i]).cast<double>();
  }
  const Embedding mean = (sum / static_cast<double>(members.size())).cast<float>();
  const json data = std::vector<double>(mean.data(), mean.data() + mean.size());
  const json& former = members.front()->at("semantic_feature");
  if (former.is_array()) return data;
  const bool is_row = former.at("rows") == 1;
  return {{"rows", is_row ? 1 : mean.size()}, {"cols", is_row ? mean.size() : 1}, {"data", data}};
}

/// Adds to `sum` and gives `merged` a mesh to be overwritten, with its header and flags.
void addMesh(const json& member, NodeMesh& sum, json& merged) {
  const NodeMesh mesh = readMesh(member, readMeshFrame(member));
  if (mesh.points_m.empty()) return;
  if (!sum.points_m.empty()) return appendMesh(mesh, sum);
  sum = mesh;
  if (mesh.form == MeshForm::kNested) merged["mesh"] = member.at("mesh");
}

void mergeMeshes(const std::vector<const json*>& members, json& merged,
                 std::vector<BadMesh>& bad_meshes) {
  NodeMesh sum;
  for (std::size_t i = 0; i < members.size(); ++i) {
    try {
      addMesh(*members[i], sum, merged);
    } catch (const std::runtime_error& e) {
      bad_meshes.push_back({i, e.what()});
    }
  }
  const MeshFrame frame = readMeshFrame(merged);
  const bool is_nested = sum.form == MeshForm::kNested;
  // The first one's mesh must not stay where the box is another one now.
  const bool has_nested = merged.contains("mesh") && merged.at("mesh").is_object();
  NodeMesh none;
  if (has_nested) writeMesh(is_nested ? sum : none, frame, merged);
  none.form = MeshForm::kFlat;
  if (merged.contains("vertices")) writeMesh(is_nested ? none : sum, frame, merged);
}

// One interval from the first observation to the last.
void mergeTimes(const std::vector<const json*>& members, json& merged) {
  const auto extend = [&](const char* name, auto isBetter) {
    json best;
    for (const json* member : members) {
      if (!member->contains(name)) continue;
      const json& value = member->at(name);
      for (const json& time : value.is_array() ? value : json::array({value})) {
        if (time.is_number() && (best.is_null() || isBetter(time, best))) best = time;
      }
    }
    if (best.is_null() || !merged.contains(name)) return;
    merged[name] = merged[name].is_array() ? json::array({best}) : best;
  };
  const auto isLess = [](const json& a, const json& b) { return a < b; };
  const auto isGreater = [](const json& a, const json& b) { return b < a; };
  extend("first_observed_ns", isLess);
  extend("last_observed_ns", isGreater);
  extend("last_update_time_ns", isGreater);
}

void mergeMeshConnections(const std::vector<const json*>& members, json& merged) {
  const auto sum = merged.find("mesh_connections");
  if (sum == merged.end() || !sum->is_array()) return;
  for (std::size_t i = 1; i < members.size(); ++i) {
    const auto more = members[i]->find("mesh_connections");
    if (more == members[i]->end() || !more->is_array()) continue;
    sum->insert(sum->end(), more->begin(), more->end());
  }
}

std::int64_t readSize(const json& feature, const char* name) {
  const json& size = getField(feature, name);
  if (size.is_number_unsigned() && size > 0 && size < 1'000'000'000) {
    return size.get<std::int64_t>();
  }
  fail("has a 'semantic_feature' with " + std::string(name) + " = " + size.dump() +
       ", expected a whole number above 0");
}

}  // namespace

Embedding readEmbedding(const json& attributes) {
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

json mergeAttributes(const std::vector<const json*>& members, std::vector<BadMesh>& bad_meshes) {
  json merged = *members.front();
  if (members.size() == 1) return merged;
  merged["bounding_box"] = mergeBoxes(members);
  merged["semantic_feature"] = mergeEmbeddings(members);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const json* member : members) sum += readPosition(*member);
  merged["position"] = toJson(sum / static_cast<double>(members.size()));
  mergeTimes(members, merged);
  mergeMeshes(members, merged, bad_meshes);
  mergeMeshConnections(members, merged);
  return merged;
}

}  // namespace tsg::bottleneck
