// SPDX-License-Identifier: BSD-3-Clause
#include "node_mesh.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace tsg::bottleneck {
namespace {

using nlohmann::json;

constexpr std::size_t kColorValues = 4;  // r, g, b, a

/// Lists with an entry per vertex, and the flag beside each that tells whether it is there.
struct VertexData {
  const char* name;
  const char* flag;
};
const std::vector<VertexData>& listVertexData(MeshForm form) {
  static const std::vector<VertexData> kNested = {{"colors", "has_colors"},
                                                  {"labels", "has_labels"},
                                                  {"stamps", "has_timestamps"},
                                                  {"first_seen_stamps", "has_first_seen_stamps"}};
  static const std::vector<VertexData> kFlat = {{"colors", ""}};
  return form == MeshForm::kFlat ? kFlat : kNested;
}

/// Empty where there is none.
const json& findList(const json& object, const char* name) {
  static const json kNone = json::array();
  const auto place = object.find(name);
  if (place == object.end() || place->is_null()) return kNone;
  if (!place->is_array()) {
    throw std::runtime_error("'" + std::string(name) + "' is no list");
  }
  return *place;
}

double readCoordinate(const json& value) {
  if (value.is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (value.is_number()) return value.get<double>();
  throw std::runtime_error("a coordinate of a vertex is " + value.dump() + ", expected a number");
}

std::size_t readIndex(const json& value, std::size_t num_points) {
  if (value.is_number_unsigned() && value.get<std::uint64_t>() < num_points) {
    return value.get<std::size_t>();
  }
  throw std::runtime_error("a face has the vertex " + value.dump() + ", expected one of 0 to " +
                           std::to_string(num_points) + " - 1");
}

/// Calls `take` with each three values, of lists of three or of one flat list.
template <typename Take>
void readTriples(const json& list, bool is_flat, const char* name, const Take& take) {
  if (is_flat) {
    if (list.size() % 3 != 0) {
      throw std::runtime_error("'" + std::string(name) + "' has " + std::to_string(list.size()) +
                               " numbers, expected three for each");
    }
    for (std::size_t i = 0; i < list.size(); i += 3) take(list[i], list[i + 1], list[i + 2]);
    return;
  }
  for (const json& triple : list) {
    if (!triple.is_array() || triple.size() != 3) {
      throw std::runtime_error("'" + std::string(name) + "' has " + triple.dump() +
                               ", expected three numbers");
    }
    take(triple[0], triple[1], triple[2]);
  }
}

/// One entry per vertex; flat colours in groups of four.
json readVertexData(const json& list, MeshForm form, std::size_t num_points) {
  if (list.size() == num_points) return list;
  if (form != MeshForm::kFlat || list.size() != kColorValues * num_points) return json();
  json groups = json::array();
  for (std::size_t i = 0; i < list.size(); i += kColorValues) {
    groups.push_back(json::array({list[i], list[i + 1], list[i + 2], list[i + 3]}));
  }
  return groups;
}

NodeMesh readMeshAs(MeshForm form, const json& holder, const MeshFrame& frame) {
  const bool is_flat = form == MeshForm::kFlat;
  const char* name = is_flat ? "vertices" : "points";
  NodeMesh mesh;
  mesh.form = form;
  readTriples(
      findList(holder, name), is_flat, name, [&](const json& x, const json& y, const json& z) {
        const Eigen::Vector3d point(readCoordinate(x), readCoordinate(y), readCoordinate(z));
        mesh.points_m.emplace_back(frame.rotation * point + frame.origin_m);
      });
  const std::size_t count = mesh.points_m.size();
  readTriples(
      findList(holder, "faces"), is_flat, "faces",
      [&](const json& a, const json& b, const json& c) {
        mesh.faces.push_back({readIndex(a, count), readIndex(b, count), readIndex(c, count)});
      });
  for (const VertexData& data : listVertexData(form)) {
    const json values = readVertexData(findList(holder, data.name), form, count);
    if (values.is_array() && !values.empty()) mesh.vertex_data[data.name] = values;
  }
  return mesh;
}

json toFlat(const json& groups) {
  json flat = json::array();
  for (const json& group : groups) {
    for (const json& value : group) flat.push_back(value);
  }
  return flat;
}

}  // namespace

NodeMesh readMesh(const json& attributes, const MeshFrame& frame) {
  const auto nested = attributes.find("mesh");
  if (nested != attributes.end() && !nested->is_null()) {
    if (!nested->is_object()) throw std::runtime_error("'mesh' is no mesh");
    if (nested->contains("points")) return readMeshAs(MeshForm::kNested, *nested, frame);
    if (nested->contains("vertices")) {
      throw std::runtime_error("'mesh' has 'vertices', expected 'points'");
    }
  }
  if (attributes.contains("vertices")) return readMeshAs(MeshForm::kFlat, attributes, frame);
  return {};
}

void appendMesh(const NodeMesh& mesh, NodeMesh& sum) {
  const std::size_t offset = sum.points_m.size();
  sum.points_m.insert(sum.points_m.end(), mesh.points_m.begin(), mesh.points_m.end());
  for (const auto& face : mesh.faces) {
    sum.faces.push_back({face[0] + offset, face[1] + offset, face[2] + offset});
  }
  for (auto it = sum.vertex_data.begin(); it != sum.vertex_data.end();) {
    const auto data = mesh.vertex_data.find(it->first);
    if (mesh.form != sum.form || data == mesh.vertex_data.end()) {
      it = sum.vertex_data.erase(it);
      continue;
    }
    it->second.insert(it->second.end(), data->second.begin(), data->second.end());
    ++it;
  }
}

void writeMesh(const NodeMesh& mesh, const MeshFrame& frame, json& attributes) {
  const bool is_flat = mesh.form == MeshForm::kFlat;
  json& holder = is_flat ? attributes : attributes["mesh"];
  json points = json::array();
  for (const Eigen::Vector3d& point_m : mesh.points_m) {
    const Eigen::Vector3d p = frame.rotation.transpose() * (point_m - frame.origin_m);
    points.push_back(json::array({p.x(), p.y(), p.z()}));
  }
  json faces = json::array();
  for (const auto& face : mesh.faces) faces.push_back(face);
  holder[is_flat ? "vertices" : "points"] = is_flat ? toFlat(points) : std::move(points);
  holder["faces"] = is_flat ? toFlat(faces) : std::move(faces);
  for (const VertexData& data : listVertexData(mesh.form)) {
    const auto kept = mesh.vertex_data.find(data.name);
    if (kept != mesh.vertex_data.end()) {
      const bool has_groups = is_flat && kept->second.front().is_array();
      holder[data.name] = has_groups ? toFlat(kept->second) : kept->second;
    } else if (is_flat) {
      holder[data.name] = json::array();
    } else {
      holder.erase(data.name);
      if (holder.contains(data.flag)) holder[data.flag] = false;
    }
  }
}

}  // namespace tsg::bottleneck
