// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/mesh_archive.h"

#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

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

Bytes pack(const Mesh& mesh) {
  Bytes raw;
  raw.reserve(countBytes(mesh.vertices.size(), mesh.triangles.size()));
  addPlanes(mesh.vertices.data(), 3 * mesh.vertices.size(), raw);
  addPlanes(mesh.triangles.data(), 3 * mesh.triangles.size(), raw);
  for (const auto& color : mesh.colors) raw.insert(raw.end(), color.begin(), color.end());
  Bytes packed(compressBound(raw.size()));
  uLongf size = packed.size();
  requireOk(compress2(packed.data(), &size, raw.data(), raw.size(), Z_BEST_SPEED), "pack");
  packed.resize(size);
  packed.shrink_to_fit();
  return packed;
}

Mesh unpack(const Bytes& packed, std::size_t vertices, std::size_t triangles) {
  Bytes raw(countBytes(vertices, triangles));
  uLongf size = raw.size();
  requireOk(uncompress(raw.data(), &size, packed.data(), packed.size()), "unpack");
  Mesh mesh;
  mesh.vertices.resize(vertices);
  mesh.triangles.resize(triangles);
  mesh.colors.resize(vertices);
  const std::uint8_t* rest = readPlanes(raw.data(), 3 * vertices, mesh.vertices.data());
  rest = readPlanes(rest, 3 * triangles, mesh.triangles.data());
  if (vertices > 0) std::memcpy(mesh.colors.data(), rest, 3 * vertices);
  return mesh;
}

}  // namespace

void MeshArchive::store(const GridIndex& block, const Mesh& mesh) {
  Bytes bytes = pack(mesh);
  Entry& entry = entries_[block];
  entry.vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  entry.triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  if (entry.bytes) memory_bytes_ -= entry.bytes->size();
  entry.bytes.reset();
  if (write(bytes, entry)) return;
  memory_bytes_ += bytes.size();
  entry.bytes = std::make_unique<Bytes>(std::move(bytes));
}

bool MeshArchive::write(const Bytes& bytes, Entry& entry) {
  if (!file_ && !is_file_broken_) file_.reset(std::tmpfile());
  is_file_broken_ |= !file_;
  if (is_file_broken_) return false;
  const auto size = static_cast<std::uint32_t>(bytes.size());
  const bool fits = size <= entry.capacity;  // into its own place of before
  const std::int64_t offset = fits ? entry.offset : file_end_;
  if (pwrite(fileno(file_.get()), bytes.data(), size, offset) != static_cast<ssize_t>(size)) {
    is_file_broken_ = true;  // what it holds can still be read
    entry.capacity = 0;
    return false;
  }
  entry.offset = offset;
  entry.size = size;
  entry.capacity = fits ? entry.capacity : size;
  file_end_ = std::max(file_end_, offset + size);
  return true;
}

Mesh MeshArchive::load(const GridIndex& block) const {
  const Entry& entry = entries_.at(block);
  return unpack(entry.bytes ? *entry.bytes : read(entry), entry.vertices, entry.triangles);
}

std::vector<std::uint8_t> MeshArchive::read(const Entry& entry) const {
  Bytes bytes(entry.size);
  if (pread(fileno(file_.get()), bytes.data(), entry.size, entry.offset) !=
      static_cast<ssize_t>(entry.size)) {
    throw std::runtime_error("cannot read " + std::to_string(entry.size) +
                             " bytes of the temporary file of archived meshes");
  }
  return bytes;
}

}  // namespace tsg::mapping
