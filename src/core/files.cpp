// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace tsg {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw std::runtime_error("cannot write '" + path.string() + "': " + what);
}

void flushToDisk(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) fail(path, std::strerror(errno));
  const int status = fsync(descriptor);
  const int error = errno;
  close(descriptor);
  if (status != 0) fail(path, std::strerror(error));
}

/// Removes the temporary file unless it was renamed.
class Cleanup {
 public:
  explicit Cleanup(fs::path path) : path_(std::move(path)) {}
  ~Cleanup() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  Cleanup(const Cleanup&) = delete;
  Cleanup& operator=(const Cleanup&) = delete;

 private:
  fs::path path_;
};

}  // namespace

void writeFileAtomically(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (error) fail(path, error.message());
  const fs::path temporary = path.string() + ".tmp" + std::to_string(getpid());
  const Cleanup cleanup(temporary);
  {
    std::ofstream stream(temporary, std::ios::binary);
    if (!stream) fail(path, std::strerror(errno));
    write(stream);
    stream.close();
    if (!stream) fail(path, "writing failed (is the disk full?)");
  }
  flushToDisk(temporary);
  fs::rename(temporary, path, error);
  if (error) fail(path, error.message());
}

}  // namespace tsg
