// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/mesh_archive.h"

#include <unistd.h>
#include <zlib.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

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

/// Sizes that places in the file have: eight to each power of two, from 64 bytes on. A place that
/// is free again fits the next mesh of its class, so the file does not crumble.
std::int64_t roundUpToClass(std::size_t bytes) {
  std::size_t step = 8;
  while (16 * step < bytes) step *= 2;
  return static_cast<std::int64_t>((bytes + step - 1) / step * step);
}

}  // namespace

/// Where a record's compressed bytes are: in the file, or here.
struct MeshArchive::Record::Place {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  std::size_t size = 0;      ///< compressed bytes
  std::int64_t offset = -1;  ///< in the file; -1 = in memory
  Bytes bytes;               ///< only in memory
};

/// The file, and which of its places are free.
class MeshArchive::Storage {
 public:
  /// Offset of where the bytes now are, or -1 if the file cannot take them.
  std::int64_t write(const Bytes& bytes) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!file_ && !is_broken_) file_.reset(std::tmpfile());
    is_broken_ |= !file_;
    if (is_broken_) return -1;
    const std::int64_t offset = findPlace(roundUpToClass(bytes.size()));
    const auto written = pwrite(fileno(file_.get()), bytes.data(), bytes.size(), offset);
    is_broken_ = written != static_cast<ssize_t>(bytes.size());
    return is_broken_ ? -1 : offset;  // what a broken file holds can still be read
  }
  Bytes read(std::int64_t offset, std::size_t size) const {
    Bytes bytes(size);
    if (pread(fileno(file_.get()), bytes.data(), size, offset) != static_cast<ssize_t>(size)) {
      throw std::runtime_error("cannot read " + std::to_string(size) +
                               " bytes of the temporary file of archived meshes");
    }
    return bytes;
  }
  void release(std::int64_t offset, std::size_t size) {
    const std::lock_guard<std::mutex> lock(mutex_);
    free_[roundUpToClass(size)].push_back(offset);
  }
  void countInMemory(std::size_t added, std::size_t removed) {
    const std::lock_guard<std::mutex> lock(mutex_);
    memory_bytes_ += added - removed;
  }
  std::size_t fileBytes() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return static_cast<std::size_t>(end_);
  }
  std::size_t memoryBytes() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return memory_bytes_;
  }

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::int64_t findPlace(std::int64_t capacity) {
    auto& places = free_[capacity];
    if (places.empty()) {
      end_ += capacity;
      return end_ - capacity;
    }
    const std::int64_t offset = places.back();
    places.pop_back();
    return offset;
  }

  mutable std::mutex mutex_;  ///< guards all below, but not what the file's places hold
  std::unique_ptr<std::FILE, CloseFile> file_;
  bool is_broken_ = false;
  std::int64_t end_ = 0;
  std::map<std::int64_t, std::vector<std::int64_t>> free_;  ///< offsets by capacity
  std::size_t memory_bytes_ = 0;
};

MeshArchive::MeshArchive() : storage_(std::make_shared<Storage>()) {}

MeshArchive::RecordPtr MeshArchive::store(const Mesh& mesh) {
  Bytes bytes = pack(mesh);
  auto place = std::make_unique<Record::Place>();
  place->vertices = mesh.vertices.size();
  place->triangles = mesh.triangles.size();
  place->size = bytes.size();
  place->offset = storage_->write(bytes);
  if (place->offset < 0) {
    storage_->countInMemory(bytes.size(), 0);
    place->bytes = std::move(bytes);
  }
  std::shared_ptr<Record> record(new Record(storage_));
  record->place_ = std::move(place);
  return record;
}

std::size_t MeshArchive::fileBytes() const { return storage_->fileBytes(); }

std::size_t MeshArchive::memoryBytes() const { return storage_->memoryBytes(); }

MeshArchive::Record::Record(std::shared_ptr<Storage> storage) : storage_(std::move(storage)) {}

MeshArchive::Record::~Record() {
  if (!place_) return;
  if (place_->offset >= 0) {
    storage_->release(place_->offset, place_->size);
  } else {
    storage_->countInMemory(0, place_->size);
  }
}

Mesh MeshArchive::Record::load() const {
  const bool is_in_file = place_->offset >= 0;
  return unpack(is_in_file ? storage_->read(place_->offset, place_->size) : place_->bytes,
                place_->vertices, place_->triangles);
}

}  // namespace tsg::mapping
