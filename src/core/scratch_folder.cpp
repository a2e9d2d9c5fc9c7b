// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/scratch_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>

namespace tsg {
namespace fs = std::filesystem;
namespace {

const std::string kPrefix = "task_scene_graph_";

/// Id of the process that made a scratch folder; 0 for other names.
pid_t readProcess(const std::string& name) {
  if (name.compare(0, kPrefix.size(), kPrefix) != 0) return 0;
  const std::string rest = name.substr(kPrefix.size());
  const std::size_t length = rest.find_first_not_of("0123456789");
  const bool is_ours = length != std::string::npos && length > 0 && length < 10 &&
                       rest[length] == '_' && rest.size() == length + 7;
  return is_ours ? static_cast<pid_t>(std::stol(rest)) : 0;
}

bool isRunning(pid_t process) { return kill(process, 0) == 0 || errno != ESRCH; }

/// An open folder that is locked for us; -1 if another process has it.
int lockFolder(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
  if (descriptor < 0 || flock(descriptor, LOCK_EX | LOCK_NB) == 0) return descriptor;
  close(descriptor);
  return -1;
}

/// The process is asked as well: one that has just made its folder may not have locked it yet.
void removeAbandoned(const fs::path& parent) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(parent, ignored)) {
    const pid_t process = readProcess(entry.path().filename().string());
    if (process == 0 || isRunning(process)) continue;
    const int lock = lockFolder(entry.path());
    if (lock < 0) continue;
    fs::remove_all(entry.path(), ignored);
    close(lock);
  }
}

}  // namespace

ScratchFolder::ScratchFolder(const fs::path& parent) {
  removeAbandoned(parent);
  std::string name = (parent / (kPrefix + std::to_string(getpid()) + "_XXXXXX")).string();
  if (mkdtemp(name.data()) == nullptr) {
    throw std::runtime_error("cannot make a folder in '" + parent.string() +
                             "': " + std::strerror(errno));
  }
  path_ = name;
  lock_ = lockFolder(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (lock_ >= 0) close(lock_);
}

}  // namespace tsg
