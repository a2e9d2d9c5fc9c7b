// SPDX-License-Identifier: BSD-3-Clause
#include "numpy_file.h"

#include <zlib.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <regex>
#include <stdexcept>

namespace tsg::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes readFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read '" + path.string() + "'");
  return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t readNumber(const Bytes& bytes, std::size_t at, int num_bytes) {
  std::size_t value = 0;
  for (int i = num_bytes - 1; i >= 0; --i) {
    value = value << 8U | bytes.at(at + static_cast<std::size_t>(i));
  }
  return value;
}

Bytes inflateRaw(const Bytes& packed, std::size_t size) {
  Bytes bytes(size);
  z_stream stream{};
  stream.next_in = const_cast<Bytef*>(packed.data());
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = bytes.data();
  stream.avail_out = static_cast<uInt>(size);
  const bool is_ok = inflateInit2(&stream, -MAX_WBITS) == Z_OK &&
                     inflate(&stream, Z_FINISH) == Z_STREAM_END && stream.total_out == size;
  inflateEnd(&stream);
  if (!is_ok) throw std::runtime_error("a packed array is damaged");
  return bytes;
}

NumpyArray parse(const Bytes& bytes, const std::string& name) {
  if (bytes.size() < 10 || std::memcmp(bytes.data(), "\x93NUMPY\x01", 7) != 0) {
    throw std::runtime_error("'" + name + "' is not a NumPy file of version 1");
  }
  const auto length = static_cast<std::ptrdiff_t>(readNumber(bytes, 8, 2));
  const std::string header(bytes.begin() + 10, bytes.begin() + 10 + length);
  NumpyArray array;
  std::smatch found;
  if (std::regex_search(header, found, std::regex("'descr': *'([^']*)'"))) array.type = found[1];
  if (std::regex_search(header, found, std::regex("'shape': *\\(([^)]*)\\)"))) {
    const std::string sizes = found[1];
    const std::regex number("[0-9]+");
    for (std::sregex_iterator i(sizes.begin(), sizes.end(), number), end; i != end; ++i) {
      array.shape.push_back(std::stoul(i->str()));
    }
  }
  array.bytes.assign(bytes.begin() + 10 + length, bytes.end());
  return array;
}

}  // namespace

NumpyArray readNpy(const std::filesystem::path& path) {
  return parse(readFile(path), path.string());
}

std::map<std::string, NumpyArray> readNpz(const std::filesystem::path& path) {
  const Bytes bytes = readFile(path);
  const Bytes mark = {'P', 'K', 1, 2};  // an entry of the directory at the end of a zip file
  std::map<std::string, NumpyArray> arrays;
  auto entry = std::search(bytes.begin(), bytes.end(), mark.begin(), mark.end());
  for (; entry != bytes.end();
       entry = std::search(entry + 4, bytes.end(), mark.begin(), mark.end())) {
    const auto at = static_cast<std::size_t>(entry - bytes.begin());
    const std::size_t local = readNumber(bytes, at + 42, 4);
    const std::size_t data =
        local + 30 + readNumber(bytes, local + 26, 2) + readNumber(bytes, local + 28, 2);
    const Bytes packed(
        bytes.begin() + static_cast<std::ptrdiff_t>(data),
        bytes.begin() + static_cast<std::ptrdiff_t>(data + readNumber(bytes, at + 20, 4)));
    const std::string name(entry + 46,
                           entry + 46 + static_cast<std::ptrdiff_t>(readNumber(bytes, at + 28, 2)));
    const bool is_packed = readNumber(bytes, at + 10, 2) != 0;
    arrays[name.substr(0, name.rfind(".npy"))] =
        parse(is_packed ? inflateRaw(packed, readNumber(bytes, at + 24, 4)) : packed, name);
  }
  if (arrays.empty()) throw std::runtime_error("'" + path.string() + "' holds no array");
  return arrays;
}

EmbeddingMatrix toUnitRows(const NumpyArray& array) {
  if (array.type != "<f2" || array.shape.size() != 2) {
    throw std::runtime_error("array is not of two dimensions and half floats");
  }
  EmbeddingMatrix rows(static_cast<Eigen::Index>(array.shape[0]),
                       static_cast<Eigen::Index>(array.shape[1]));
  const auto* values = reinterpret_cast<const Eigen::half*>(array.bytes.data());
  for (Eigen::Index i = 0; i < rows.size(); ++i) rows.data()[i] = static_cast<float>(values[i]);
  return rows.rowwise().normalized();
}

}  // namespace tsg::test
