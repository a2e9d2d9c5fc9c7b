// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/file_kind.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <fstream>
#include <system_error>

namespace tsg {
namespace {

constexpr std::size_t kNumFirstBytes = 256;

struct Kind {
  std::string beginning;
  const char* what;
};

const Kind kKinds[] = {
    {std::string("\x1f\x8b"), "is packed with gzip; unpack it first (gunzip)"},
    {"BZh", "is packed with bzip2; unpack it first (bunzip2)"},
    {std::string("\xfd") + "7zXZ", "is packed with xz; unpack it first (unxz)"},
    {"\x28\xb5\x2f\xfd", "is packed with zstd; unpack it first (unzstd)"},
    {"7z\xbc\xaf", "is a 7z archive; unpack it first"},
    {"PK\x03\x04", "is a zip archive (PyTorch's .pt and .pth files are such, too)"},
    {"version https://git-lfs", "is a pointer of Git LFS; 'git lfs pull' gets the file itself"},
    {"#ROSBAG", "is a ROS bag"},
    {"SQLite format 3", "is an SQLite database (ROS 2 bags are such)"},
    {"\xff\xfe", "is text in UTF-16; convert it to UTF-8"},
    {"\xfe\xff", "is text in UTF-16; convert it to UTF-8"},
    {"\x89HDF", "is an HDF5 file"},
    {"\x89PNG", "is a PNG image"},
    {"\xff\xd8\xff", "is a JPEG image"},
    {"%PDF", "is a PDF document"},
    {"ply\n", "is a PLY file"},
};

bool startsWith(const std::string& text, const std::string& beginning) {
  return text.compare(0, beginning.size(), beginning) == 0;
}

std::string describeMarkup(std::string text) {
  text.erase(0, text.find_first_not_of(" \t\r\n"));
  if (!startsWith(text, "<")) return "";
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool is_page = startsWith(text, "<!doctype html") || startsWith(text, "<html");
  return is_page ? "is a web page; download the file itself" : "is XML";
}

}  // namespace

std::string describeFirstBytes(const std::string& first_bytes) {
  if (first_bytes.empty()) return "is empty";
  for (const Kind& kind : kKinds) {
    if (startsWith(first_bytes, kind.beginning)) return kind.what;
  }
  if (first_bytes.size() >= 8 && first_bytes.compare(4, 4, "TFL3") == 0) {
    return "is a TensorFlow Lite network";
  }
  return describeMarkup(first_bytes);
}

std::string describeFileKind(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return "is a folder";
  std::ifstream in(path, std::ios::binary);
  if (!in) return "cannot be opened";
  std::string bytes(kNumFirstBytes, '\0');
  in.read(&bytes[0], static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return describeFirstBytes(bytes);
}

}  // namespace tsg
