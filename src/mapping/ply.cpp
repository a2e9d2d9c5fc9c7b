// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/ply.h"

#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "task_scene_graph/core/files.h"

namespace tsg::mapping {
namespace {

namespace fs = std::filesystem;

// Bytes are written in the machine's order; every supported machine is little-endian.
template <typename T>
void append(std::string& buffer, const T& value) {
  const std::size_t size = buffer.size();
  buffer.resize(size + sizeof(T));
  std::memcpy(&buffer[size], &value, sizeof(T));
}

std::string makeHeader(const Mesh& mesh, bool with_ids, const std::string& frame) {
  std::ostringstream header;
  header << "ply\nformat binary_little_endian 1.0\n"
         << (frame.empty() ? "" : "comment frame " + frame + "\n") << "element vertex "
         << mesh.vertices.size() << "\n"
         << "property float x\nproperty float y\nproperty float z\n"
         << "property uchar red\nproperty uchar green\nproperty uchar blue\n"
         << (with_ids ? "property int object_id\n" : "") << "element face " << mesh.triangles.size()
         << "\nproperty list uchar int vertex_indices\nend_header\n";
  return header.str();
}

std::string makeBody(const Mesh& mesh, const std::vector<std::int32_t>* object_ids) {
  std::string body;
  body.reserve(mesh.vertices.size() * 19 + mesh.triangles.size() * 13);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) append(body, mesh.vertices[i][axis]);
    append(body, mesh.colors[i]);
    if (object_ids != nullptr) append(body, (*object_ids)[i]);
  }
  for (const auto& triangle : mesh.triangles) {
    append(body, std::uint8_t{3});
    for (const std::uint32_t vertex : triangle) append(body, static_cast<std::int32_t>(vertex));
  }
  return body;
}

void requireCount(const char* what, std::size_t count, const Mesh& mesh) {
  if (count == mesh.vertices.size()) return;
  throw std::invalid_argument("PLY: " + std::to_string(count) + " " + what + ", expected " +
                              std::to_string(mesh.vertices.size()) + ", one per vertex");
}

void write(const fs::path& path, const Mesh& mesh, const std::vector<std::int32_t>* object_ids,
           const std::string& frame) {
  requireCount("colours", mesh.colors.size(), mesh);
  if (object_ids != nullptr) requireCount("object ids", object_ids->size(), mesh);
  writeFileAtomically(path, [&](std::ostream& stream) {
    stream << makeHeader(mesh, object_ids != nullptr, frame) << makeBody(mesh, object_ids);
  });
}

}  // namespace

void writePly(const fs::path& path, const Mesh& mesh) { write(path, mesh, nullptr, ""); }

void writePly(const fs::path& path, const Mesh& mesh, const std::vector<std::int32_t>& object_ids,
              const std::string& frame) {
  write(path, mesh, &object_ids, frame);
}

}  // namespace tsg::mapping
