// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/binary.h"

#include <zlib.h>

#include <array>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include "task_scene_graph/core/files.h"

namespace tsg {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kKindBytes = 16;  // of the kind's name, filled up with zeros
constexpr std::size_t kChunkBytes = std::size_t{1} << 18;

std::array<char, kKindBytes> toKindBytes(const std::string& kind) {
  std::array<char, kKindBytes> bytes{};
  kind.copy(bytes.data(), kKindBytes - 1);
  return bytes;
}

std::string toText(const std::array<char, kKindBytes>& bytes) {
  std::string text;
  for (const char c : bytes) {
    if (c == 0) break;
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  return text;
}

/// Ends a zlib stream whatever happens.
struct Deflater {
  z_stream stream{};
  Deflater() {
    if (deflateInit(&stream, Z_BEST_SPEED) != Z_OK) throw std::runtime_error("zlib: no memory");
  }
  ~Deflater() { deflateEnd(&stream); }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;
};

struct Inflater {
  z_stream stream{};
  Inflater() {
    if (inflateInit(&stream) != Z_OK) throw std::runtime_error("zlib: no memory");
  }
  ~Inflater() { inflateEnd(&stream); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
};

/// What is written to it goes compressed to another stream.
class DeflatingBuffer : public std::streambuf {
 public:
  explicit DeflatingBuffer(std::ostream& to) : to_(to), pending_(kChunkBytes) {
    setp(pending_.data(), pending_.data() + pending_.size());
  }
  void finish() { deflateAll(Z_FINISH); }

 protected:
  int_type overflow(int_type c) override {
    deflateAll(Z_NO_FLUSH);
    if (c != traits_type::eof()) sputc(traits_type::to_char_type(c));
    return to_ ? traits_type::not_eof(c) : traits_type::eof();
  }

 private:
  void deflateAll(int flush) {
    z_stream& z = deflater_.stream;
    z.next_in = reinterpret_cast<Bytef*>(pbase());
    z.avail_in = static_cast<uInt>(pptr() - pbase());
    std::vector<char> packed(kChunkBytes);
    do {
      z.next_out = reinterpret_cast<Bytef*>(packed.data());
      z.avail_out = static_cast<uInt>(packed.size());
      deflate(&z, flush);
      to_.write(packed.data(), static_cast<std::streamsize>(packed.size() - z.avail_out));
    } while (z.avail_out == 0);
    setp(pending_.data(), pending_.data() + pending_.size());
  }

  std::ostream& to_;
  std::vector<char> pending_;
  Deflater deflater_;
};

/// @throws std::runtime_error if the bytes are damaged or end too soon.
std::string inflateAll(std::istream& from) {
  Inflater inflater;
  z_stream& z = inflater.stream;
  std::string all;
  std::vector<char> packed(kChunkBytes);
  std::vector<char> part(kChunkBytes);
  int status = Z_OK;
  while (status != Z_STREAM_END) {
    from.read(packed.data(), static_cast<std::streamsize>(packed.size()));
    if (from.gcount() == 0) throw std::runtime_error("is damaged: it ends too soon");
    z.next_in = reinterpret_cast<Bytef*>(packed.data());
    z.avail_in = static_cast<uInt>(from.gcount());
    do {
      z.next_out = reinterpret_cast<Bytef*>(part.data());
      z.avail_out = static_cast<uInt>(part.size());
      status = inflate(&z, Z_NO_FLUSH);
      if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR) {
        throw std::runtime_error(std::string("is damaged: ") + (z.msg == nullptr ? "?" : z.msg));
      }
      all.append(part.data(), part.size() - z.avail_out);
    } while (z.avail_out == 0);
  }
  return all;
}

void requireHead(std::istream& stream, const std::string& kind, std::uint32_t version) {
  std::array<char, kKindBytes> found{};
  std::uint32_t found_version = 0;
  stream.read(found.data(), static_cast<std::streamsize>(found.size()));
  stream.read(reinterpret_cast<char*>(&found_version), sizeof(found_version));
  if (!stream) throw std::runtime_error("is damaged: it ends within its head");
  if (found != toKindBytes(kind)) {
    throw std::runtime_error("begins with '" + toText(found) + "', expected '" + kind + "'");
  }
  if (found_version != version) {
    throw std::runtime_error("is of version " + std::to_string(found_version) + ", expected " +
                             std::to_string(version));
  }
}

}  // namespace

void BinaryWriter::putString(const std::string& text) {
  put(static_cast<std::uint64_t>(text.size()));
  putBytes(text.data(), text.size());
}

void BinaryReader::fail(const std::string& what) const {
  throw std::runtime_error("is damaged: " + what + " at byte " + std::to_string(next_) + " of " +
                           std::to_string(bytes_.size()));
}

void BinaryReader::requireBytes(std::uint64_t count, std::size_t item_bytes) const {
  const std::uint64_t left = bytes_.size() - next_;
  if (item_bytes > 0 && count > left / item_bytes) {
    fail(std::to_string(count) + " items of " + std::to_string(item_bytes) + " bytes");
  }
}

std::size_t BinaryReader::getCount(std::size_t item_bytes) {
  const auto count = get<std::uint64_t>();
  requireBytes(count, item_bytes);
  return static_cast<std::size_t>(count);
}

std::string BinaryReader::getString() {
  std::string text(getCount(1), '\0');
  getBytes(text.data(), text.size());
  return text;
}

void BinaryReader::getBytes(void* bytes, std::size_t size) {
  requireBytes(size, 1);
  if (size > 0) std::memcpy(bytes, bytes_.data() + next_, size);
  next_ += size;
}

void writeBinaryFile(const fs::path& path, const std::string& kind, std::uint32_t version,
                     const std::function<void(BinaryWriter&)>& write) {
  writeFileAtomically(path, [&](std::ostream& out) {
    const auto kind_bytes = toKindBytes(kind);
    out.write(kind_bytes.data(), static_cast<std::streamsize>(kind_bytes.size()));
    out.write(reinterpret_cast<const char*>(&version), sizeof(version));
    DeflatingBuffer buffer(out);
    std::ostream stream(&buffer);
    BinaryWriter writer(stream);
    write(writer);
    buffer.finish();
  });
}

void readBinaryFile(const fs::path& path, const std::string& kind, std::uint32_t version,
                    const std::function<void(BinaryReader&)>& read) {
  requireFile("file", path);
  try {
    std::ifstream stream(path, std::ios::binary);
    requireHead(stream, kind, version);
    BinaryReader reader(inflateAll(stream));
    read(reader);
    if (!reader.isAtEnd()) throw std::runtime_error("is damaged: it holds more than expected");
  } catch (const std::exception& e) {
    throw std::runtime_error("file '" + path.string() + "' " + e.what());
  }
}

std::uint32_t computeCrc32(const fs::path& path) {
  requireFile("file", path);
  std::ifstream stream(path, std::ios::binary);
  uLong crc = crc32(0L, Z_NULL, 0);
  std::vector<char> part(kChunkBytes);
  while (stream.read(part.data(), static_cast<std::streamsize>(part.size())), stream.gcount() > 0) {
    crc =
        crc32(crc, reinterpret_cast<const Bytef*>(part.data()), static_cast<uInt>(stream.gcount()));
  }
  return static_cast<std::uint32_t>(crc);
}

}  // namespace tsg
