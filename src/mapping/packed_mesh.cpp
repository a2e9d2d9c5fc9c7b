// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/packed_mesh.h"

#include <zlib.h>

#include <cstring>
#include <stdexcept>
#include <string>

namespace tsg::mapping {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kWord = 4;  // bytes of a coordinate and of a vertex index

/// The first bytes of all words, then all second bytes, ...: alike bytes beside each other, which
/// is what makes words compress.
void addPlanes(const void* words, std::size_t count, Bytes& to) {
  const auto* from = static_cast<const std::uint8_t*>(words);
  for (std::size_t byte = 0; byte < kWord; ++byte) {
    for (std::size_t i = 0; i < count; ++i) to.push_back(from[kWord * i + byte]);
  }
}

/// Returns where the planes end.
const std::uint8_t* readPlanes(const std::uint8_t* planes, std::size_t count, void* words) {
  auto* to = static_cast<std::uint8_t*>(words);
  for (std::size_t byte = 0; byte < kWord; ++byte) {
    for (std::size_t i = 0; i < count; ++i) to[kWord * i + byte] = *planes++;
  }
  return planes;
}

void requireOk(int status, const char* what) {
  if (status == Z_OK) return;
  throw std::runtime_error(std::string("cannot ") + what + " a mesh: zlib says " +
                           std::to_string(status));
}

std::size_t countBytes(std::size_t vertices, std::size_t triangles) {
  return vertices * (3 * kWord + 3) + triangles * 3 * kWord;
}

}  // namespace

PackedMesh::PackedMesh(const Mesh& mesh)
    : vertices_(mesh.vertices.size()), triangles_(mesh.triangles.size()) {
  Bytes raw;
  raw.reserve(countBytes(vertices_, triangles_));
  addPlanes(mesh.vertices.data(), 3 * vertices_, raw);
  addPlanes(mesh.triangles.data(), 3 * triangles_, raw);
  for (const auto& color : mesh.colors) raw.insert(raw.end(), color.begin(), color.end());
  Bytes packed(compressBound(raw.size()));
  uLongf size = packed.size();
  requireOk(compress2(packed.data(), &size, raw.data(), raw.size(), Z_BEST_SPEED), "pack");
  bytes_.assign(packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size));
}

Mesh PackedMesh::unpack() const {
  Bytes raw(countBytes(vertices_, triangles_));
  uLongf size = raw.size();
  requireOk(uncompress(raw.data(), &size, bytes_.data(), bytes_.size()), "unpack");
  Mesh mesh;
  mesh.vertices.resize(vertices_);
  mesh.triangles.resize(triangles_);
  mesh.colors.resize(vertices_);
  const std::uint8_t* rest = readPlanes(raw.data(), 3 * vertices_, mesh.vertices.data());
  rest = readPlanes(rest, 3 * triangles_, mesh.triangles.data());
  if (vertices_ > 0) std::memcpy(mesh.colors.data(), rest, 3 * vertices_);
  return mesh;
}

}  // namespace tsg::mapping
