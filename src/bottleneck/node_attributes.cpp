// SPDX-License-Identifier: BSD-3-Clause
#include "node_attributes.h"

#include <algorithm>
#include <stdexcept>

namespace tsg::bottleneck {
namespace {

using nlohmann::json;

[[noreturn]] void fail(const std::string& what) { throw std::runtime_error(what); }

const json& getField(const json& object, const char* name) {
  const auto place = object.find(name);
  if (place == object.end()) fail("has no '" + std::string(name) + "'");
  return *place;
}

Eigen::Vector3d readVector(const json& object, const char* name) {
  const json& value = getField(object, name);
  const bool is_vector =
      value.is_array() && value.size() == 3 &&
      std::all_of(value.begin(), value.end(), [](const json& x) { return x.is_number(); });
  if (!is_vector)
    fail("has '" + std::string(name) + "' = " + value.dump() + ", expected 3 numbers");
  return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

bool isValid(const json& box) {
  const json& type = getField(box, "type");
  return !(type.is_null() || type == "INVALID" || type == 0);
}

bool isAxisAligned(const json& box) {
  const json& type = getField(box, "type");
  return type == "AABB" || type == 1;
}

Eigen::Matrix3d readRotation(const json& box) {
  if (isAxisAligned(box) || !box.contains("world_R_center")) return Eigen::Matrix3d::Identity();
  const json& q = box.at("world_R_center");
  return Eigen::Quaterniond(q.at("w").get<double>(), q.at("x").get<double>(),
                            q.at("y").get<double>(), q.at("z").get<double>())
      .normalized()
      .toRotationMatrix();
}

// Before 1.0.3 the size was given as two corners around the centre.
bool hasCorners(const json& box) { return box.contains("min") && box.contains("max"); }

Eigen::Vector3d readDimensions(const json& box) {
  if (!box.contains("dimensions") && hasCorners(box)) {
    return readVector(box, "max") - readVector(box, "min");
  }
  return readVector(box, "dimensions");
}

json toJson(const Eigen::Vector3d& v) { return json::array({v.x(), v.y(), v.z()}); }

json mergeBoxes(const std::vector<const json*>& members) {
  json box = members.front()->at("bounding_box");
  Aabb hull;
  for (const json* member : members) hull.extend(readBox(*member));
  if (hull.isEmpty()) return box;
  box["type"] = box.at("type").is_number() ? json(1) : json("AABB");
  box["world_P_center"] = toJson(hull.center());
  box["world_R_center"] = {{"w", 1.0}, {"x", 0.0}, {"y", 0.0}, {"z", 0.0}};
  if (hasCorners(box)) {
    box["min"] = toJson(-hull.sizes() / 2.0);
    box["max"] = toJson(hull.sizes() / 2.0);
  } else {
    box["dimensions"] = toJson(hull.sizes());
  }
  return box;
}

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

bool hasMesh(const json& attributes) {
  return attributes.contains("mesh") && attributes.at("mesh").is_object() &&
         attributes.at("mesh").contains("points") && !attributes.at("mesh").at("points").empty();
}

// Vertices are relative to the box's centre and axes.
void appendVertices(const json& attributes, const json& merged_box, json& mesh) {
  const json& box = attributes.at("bounding_box");
  const Eigen::Matrix3d rotation = readRotation(box);
  const Eigen::Vector3d shift =
      readVector(box, "world_P_center") - readVector(merged_box, "world_P_center");
  const std::size_t offset = mesh.at("points").size();
  for (const json& point : attributes.at("mesh").at("points")) {
    const Eigen::Vector3d p(point[0].get<double>(), point[1].get<double>(), point[2].get<double>());
    mesh["points"].push_back(toJson(rotation * p + shift));
  }
  for (const json& face : getField(attributes.at("mesh"), "faces")) {
    json& added = mesh["faces"].emplace_back(face);
    for (json& index : added) index = index.get<std::size_t>() + offset;
  }
}

// Per-vertex data that all parts have.
void appendVertexData(const std::vector<const json*>& parts, const char* name, json& mesh) {
  json data = json::array();
  for (const json* part : parts) {
    const json& source = part->at("mesh");
    if (!source.contains(name) || source.at(name).size() != source.at("points").size()) {
      mesh.erase(name);
      mesh["has_" + std::string(name)] = false;
      return;
    }
    data.insert(data.end(), source.at(name).begin(), source.at(name).end());
  }
  mesh[name] = std::move(data);
}

json mergeMeshes(const std::vector<const json*>& members, const json& merged_box) {
  std::vector<const json*> parts;
  std::copy_if(members.begin(), members.end(), std::back_inserter(parts),
               [](const json* member) { return hasMesh(*member); });
  if (parts.empty()) return members.front()->at("mesh");
  json mesh = parts.front()->at("mesh");
  mesh["points"] = mesh["faces"] = json::array();
  for (const json* part : parts) appendVertices(*part, merged_box, mesh);
  for (const char* name : {"colors", "labels", "timestamps", "first_seen_stamps"}) {
    if (mesh.contains(name)) appendVertexData(parts, name, mesh);
  }
  return mesh;
}

// One interval from the first observation to the last.
void mergeTimes(const std::vector<const json*>& members, json& merged) {
  const auto extend = [&](const char* name, auto isBetter) {
    json best;
    for (const json* member : members) {
      if (!member->contains(name)) continue;
      const json& value = member->at(name);
      for (const json& time : value.is_array() ? value : json::array({value})) {
        if (best.is_null() || isBetter(time, best)) best = time;
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

}  // namespace

Aabb readBox(const json& attributes) {
  const json& box = getField(attributes, "bounding_box");
  if (!isValid(box)) return {};
  const Eigen::Vector3d half = readDimensions(box) / 2.0;
  const Eigen::Vector3d reach = readRotation(box).cwiseAbs() * half;
  const Eigen::Vector3d center = readVector(box, "world_P_center");
  return makeAabb(center - reach, center + reach);
}

Embedding readEmbedding(const json& attributes) {
  const json& feature = getField(attributes, "semantic_feature");
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
  if (feature.is_array()) return values;
  const auto rows = getField(feature, "rows").get<Eigen::Index>();
  const auto cols = getField(feature, "cols").get<Eigen::Index>();
  if (rows * cols != values.size()) {
    fail("has a 'semantic_feature' of " + std::to_string(values.size()) + " entries, expected " +
         std::to_string(rows) + " x " + std::to_string(cols));
  }
  if (rows == 1 || cols == 1) return values;
  return Eigen::Map<const EmbeddingMatrix>(values.data(), rows, cols).rowwise().mean();
}

Eigen::Vector3d readPosition(const json& attributes) { return readVector(attributes, "position"); }

json mergeAttributes(const std::vector<const json*>& members) {
  json merged = *members.front();
  if (members.size() == 1) return merged;
  merged["bounding_box"] = mergeBoxes(members);
  merged["semantic_feature"] = mergeEmbeddings(members);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const json* member : members) sum += readPosition(*member);
  merged["position"] = toJson(sum / static_cast<double>(members.size()));
  mergeTimes(members, merged);
  if (merged.contains("mesh")) merged["mesh"] = mergeMeshes(members, merged["bounding_box"]);
  if (!merged.contains("mesh_connections")) return merged;
  for (std::size_t i = 1; i < members.size(); ++i) {
    for (const json& vertex : members[i]->value("mesh_connections", json::array())) {
      merged["mesh_connections"].push_back(vertex);
    }
  }
  return merged;
}

}  // namespace tsg::bottleneck
