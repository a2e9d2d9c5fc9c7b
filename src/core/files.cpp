// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace tsg {
namespace fs = std::filesystem;
namespace {

constexpr const char* kTemporary = ".tmp";  // and the process's id

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

bool isRunning(long pid) { return kill(static_cast<pid_t>(pid), 0) == 0 || errno != ESRCH; }

/// Removes what processes that were killed have left of writing the same file.
void removeStale(const fs::path& path) {
  const std::string prefix = path.filename().string() + kTemporary;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    const std::string pid = name.size() > prefix.size() ? name.substr(prefix.size()) : "";
    const bool is_pid =
        !pid.empty() && pid.size() < 10 && pid.find_first_not_of("0123456789") == std::string::npos;
    if (name.compare(0, prefix.size(), prefix) != 0 || !is_pid) continue;
    if (!isRunning(std::stol(pid))) fs::remove(entry.path(), ignored);
  }
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

void requireFile(const std::string& what, const fs::path& path) {
  const std::string where = what + " '" + fs::absolute(path).string() + "'";
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) throw std::runtime_error(where + " is not there");
  if (fs::is_directory(status)) throw std::runtime_error(where + " is a folder, expected a file");
  if (access(path.c_str(), R_OK) == 0) return;
  throw std::runtime_error(where + " cannot be read: " + std::strerror(errno));
}

void replaceFile(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (error) fail(path, error.message());
  removeStale(path);
  const fs::path temporary = path.string() + kTemporary + std::to_string(getpid());
  const Cleanup cleanup(temporary);
  write(temporary);
  flushToDisk(temporary);
  fs::rename(temporary, path, error);
  if (error) fail(path, error.message());
}

void writeFileAtomically(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  replaceFile(path, [&](const fs::path& temporary) {
    std::ofstream stream(temporary, std::ios::binary);
    if (!stream) fail(path, std::strerror(errno));
    write(stream);
    stream.close();
    if (!stream) fail(path, "writing failed (is the disk full?)");
  });
}

std::string formatCount(std::size_t count, const std::string& singular) {
  return std::to_string(count) + " " + singular + (count == 1 ? "" : "s");
}

std::string describeWritten(const fs::path& folder, const std::vector<WrittenFile>& files) {
  std::string text;
  for (const auto& file : files) {
    text += (text.empty() ? "" : ", ") + file.name;
    if (!file.content.empty()) text += " (" + file.content + ")";
  }
  return folder.empty() ? "wrote " + text : "wrote " + folder.string() + ": " + text;
}

}  // namespace tsg
