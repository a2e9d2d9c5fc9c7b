// SPDX-License-Identifier: BSD-3-Clause
#include "node_mesh.h"

#include <limits>
#include <optional>
#include <stdexcept>

#include "json_numbers.h"

namespace tsg::scene_graph {
namespace {

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

/// Nothing where there is none.
std::optional<JsonSpan> findList(const JsonText& text, const JsonObject& object, const char* name) {
  const JsonSpan* list = object.find(name);
  if (list == nullptr || text.isNull(*list)) return std::nullopt;
  if (!text.isArray(*list)) throw std::runtime_error("'" + std::string(name) + "' is no list");
  return *list;
}

double readCoordinate(const JsonText& text, JsonSpan value) {
  if (text.isNull(value)) return std::numeric_limits<double>::quiet_NaN();
  if (const auto number = text.readNumber(value)) return *number;
  throw std::runtime_error("a coordinate of a vertex is " + text.copy(value) +
                           ", expected a number");
}

std::size_t readIndex(const JsonText& text, JsonSpan value, std::size_t num_points) {
  const auto index = text.readUnsigned(value);
  if (index && *index < num_points) return static_cast<std::size_t>(*index);
  throw std::runtime_error("a face has the vertex " + text.copy(value) + ", expected one of 0 to " +
                           std::to_string(num_points) + " - 1");
}

/// Calls `take` with each three values, of lists of three or of one flat list.
template <typename Take>
void readTriples(const JsonText& text, const JsonObject& holder, bool is_flat, const char* name,
                 const Take& take) {
  const auto list = findList(text, holder, name);
  if (!list) return;
  const std::vector<JsonSpan> entries = text.readArray(*list);
  if (is_flat) {
    if (entries.size() % 3 != 0) {
      throw std::runtime_error("'" + std::string(name) + "' has " + std::to_string(entries.size()) +
                               " numbers, expected three for each");
    }
    for (std::size_t i = 0; i < entries.size(); i += 3) {
      take(entries[i], entries[i + 1], entries[i + 2]);
    }
    return;
  }
  for (const JsonSpan entry : entries) {
    const std::vector<JsonSpan> triple = text.readArray(entry);
    if (triple.size() != 3) {
      throw std::runtime_error("'" + std::string(name) + "' has " + text.copy(entry) +
                               ", expected three numbers");
    }
    take(triple[0], triple[1], triple[2]);
  }
}

/// The entries as they stand there; nothing unless there is one per vertex, or four numbers in a
/// flat mesh.
std::string readVertexData(const JsonText& text, const JsonObject& holder, const char* name,
                           MeshForm form, std::size_t num_points) {
  const auto list = findList(text, holder, name);
  if (!list) return "";
  const std::size_t count = text.readArray(*list).size();
  const bool is_per_vertex =
      count == num_points || (form == MeshForm::kFlat && count == kColorValues * num_points);
  return is_per_vertex && count > 0 ? text.copy({list->begin + 1, list->end - 1}) : "";
}

NodeMesh readMeshAs(MeshForm form, const JsonText& text, const JsonObject& holder,
                    const MeshFrame& frame) {
  const bool is_flat = form == MeshForm::kFlat;
  NodeMesh mesh;
  mesh.form = form;
  readTriples(text, holder, is_flat, is_flat ? "vertices" : "points",
              [&](JsonSpan x, JsonSpan y, JsonSpan z) {
                const Eigen::Vector3d point(readCoordinate(text, x), readCoordinate(text, y),
                                            readCoordinate(text, z));
                mesh.points_m.emplace_back(frame.rotation * point + frame.origin_m);
              });
  const std::size_t count = mesh.points_m.size();
  readTriples(text, holder, is_flat, "faces", [&](JsonSpan a, JsonSpan b, JsonSpan c) {
    mesh.faces.push_back(
        {readIndex(text, a, count), readIndex(text, b, count), readIndex(text, c, count)});
  });
  for (const VertexData& data : listVertexData(form)) {
    std::string entries = readVertexData(text, holder, data.name, form, count);
    if (!entries.empty()) mesh.vertex_data[data.name] = std::move(entries);
  }
  return mesh;
}

/// "[[1,2,3],[4,5,6]]", or "[1,2,3,4,5,6]". @param append  appends a value to a text
template <typename Triples, typename Append>
std::string writeTriples(const Triples& triples, bool is_flat, const Append& append) {
  std::string text = "[";
  for (const auto& triple : triples) {
    if (text.size() > 1) text += ',';
    if (!is_flat) text += '[';
    for (int k = 0; k < 3; ++k) {
      if (k > 0) text += ',';
      append(triple, k, text);
    }
    if (!is_flat) text += ']';
  }
  return text + ']';
}

std::string writePoints(const NodeMesh& mesh, const MeshFrame& frame, bool is_flat) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& point_m : mesh.points_m) {
    points.emplace_back(frame.rotation.transpose() * (point_m - frame.origin_m));
  }
  return writeTriples(points, is_flat, [](const Eigen::Vector3d& p, int k, std::string& text) {
    appendNumber(p[k], text);
  });
}

std::string writeFaces(const NodeMesh& mesh, bool is_flat) {
  return writeTriples(mesh.faces, is_flat,
                      [](const std::array<std::size_t, 3>& f, int k, std::string& text) {
                        text += std::to_string(f[static_cast<std::size_t>(k)]);
                      });
}

}  // namespace

NodeMesh readMesh(const JsonText& text, const JsonObject& attributes, const MeshFrame& frame) {
  const JsonSpan* nested = attributes.find("mesh");
  if (nested != nullptr && !text.isNull(*nested)) {
    if (!text.isObject(*nested)) throw std::runtime_error("'mesh' is no mesh");
    const JsonObject holder = text.readObject(*nested);
    if (holder.find("points") != nullptr) {
      return readMeshAs(MeshForm::kNested, text, holder, frame);
    }
    if (holder.find("vertices") != nullptr) {
      throw std::runtime_error("'mesh' has 'vertices', expected 'points'");
    }
  }
  if (attributes.find("vertices") == nullptr) return {};
  return readMeshAs(MeshForm::kFlat, text, attributes, frame);
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
    it->second += ',' + data->second;
    ++it;
  }
}

std::string writeNestedMesh(const NodeMesh& mesh, const MeshFrame& frame, const JsonText& text,
                            const JsonObject& holder) {
  FieldTexts fields = {{"points", writePoints(mesh, frame, false)},
                       {"faces", writeFaces(mesh, false)}};
  for (const VertexData& data : listVertexData(MeshForm::kNested)) {
    const auto kept = mesh.vertex_data.find(data.name);
    if (kept != mesh.vertex_data.end()) {
      fields.emplace_back(data.name, '[' + kept->second + ']');
    } else {
      fields.emplace_back(data.name, kNoField);
      if (holder.find(data.flag) != nullptr) fields.emplace_back(data.flag, "false");
    }
  }
  return replaceFields(text, holder, fields);
}

FieldTexts writeFlatMesh(const NodeMesh& mesh, const MeshFrame& frame) {
  FieldTexts fields = {{"vertices", writePoints(mesh, frame, true)},
                       {"faces", writeFaces(mesh, true)}};
  for (const VertexData& data : listVertexData(MeshForm::kFlat)) {
    const auto kept = mesh.vertex_data.find(data.name);
    const std::string entries = kept == mesh.vertex_data.end() ? std::string() : kept->second;
    fields.emplace_back(data.name, '[' + entries + ']');
  }
  return fields;
}

}  // namespace tsg::scene_graph
