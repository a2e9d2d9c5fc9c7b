// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/map/folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "folder_lock.h"
#include "manifest.h"

namespace tsg::map {
namespace fs = std::filesystem;
namespace {

// Where the new files are written, with the process's id; and where they are once all of them are
// there. A folder of the second name is the map, as far as it has files (a redo log).
constexpr const char* kWriting = ".saving.";
constexpr const char* kReady = ".saved";

// A stage that is asked to write may itself be waited for by the one that holds the lock.
constexpr std::chrono::seconds kLockPatience{20};

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw std::runtime_error("cannot write map '" + path.string() + "': " + what);
}

void flushFolder(const fs::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) fail(folder, std::strerror(errno));
  fsync(descriptor);  // some file systems know no flushing of folders: what can be done is done
  close(descriptor);
}

void moveTo(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) fail(to, error.message());
}

/// Removes a folder that never became the map.
class Cleanup {
 public:
  explicit Cleanup(fs::path folder) : folder_(std::move(folder)) {}
  ~Cleanup() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Cleanup(const Cleanup&) = delete;
  Cleanup& operator=(const Cleanup&) = delete;

 private:
  fs::path folder_;
};

/// Names of the files below a folder.
std::vector<std::string> listFiles(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    names.push_back(entry.path().lexically_relative(folder).generic_string());
  }
  return names;
}

/// What processes that were killed have left. The lock is held, so none of them is at work here;
/// a stage that one of them had asked to write may be: what it still writes goes the next time.
void removeUnfinished(const fs::path& folder) {
  std::vector<fs::path> unfinished;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename().string().rfind(kWriting, 0) == 0)
      unfinished.push_back(entry.path());
  }
  std::error_code ignored;
  for (const auto& path : unfinished) fs::remove_all(path, ignored);
}

/// Of the map of before, as it lies in the folder itself; nothing if there is none that can be
/// read.
std::optional<Manifest> findManifest(const fs::path& folder) {
  if (!fs::exists(folder / kManifestName)) return std::nullopt;
  try {
    return readManifestFile(folder / kManifestName);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

/// Removes files of the map of before which the new one has not, then empty folders of theirs.
void removeStale(const fs::path& folder, const std::map<std::string, FileRecord>& before,
                 const std::map<std::string, FileRecord>& now) {
  std::error_code ignored;
  for (const auto& [name, record] : before) {
    if (now.count(name) > 0) continue;
    fs::remove(folder / name, ignored);
    const fs::path parent = (folder / name).parent_path();
    if (parent != folder && fs::is_empty(parent, ignored)) fs::remove(parent, ignored);
  }
}

/// Moves what is ready into place; where that was interrupted, the rest.
void moveIntoPlace(const fs::path& folder) {
  const fs::path ready = folder / kReady;
  if (fs::exists(ready / kManifestName)) {
    const Manifest manifest = readManifestFile(ready / kManifestName);
    for (const std::string& name : listFiles(ready)) {
      if (name == kManifestName) continue;
      fs::create_directories((folder / name).parent_path());
      moveTo(ready / name, folder / name);
    }
    if (const auto before = findManifest(folder))
      removeStale(folder, before->files, manifest.files);
    moveTo(ready / kManifestName, folder / kManifestName);
    flushFolder(folder);
  }
  fs::remove_all(ready);
}

/// The manifest of what was written, and of what is kept.
Manifest makeManifest(const fs::path& written, const std::optional<ManifestHead>& head,
                      const std::optional<Manifest>& before, OtherFiles others) {
  Manifest manifest;
  if (before && (others == OtherFiles::kKeep || !head)) manifest.head = before->head;
  if (head) manifest.head = *head;
  if (before && others == OtherFiles::kKeep) manifest.files = before->files;
  for (const std::string& name : listFiles(written)) {
    manifest.files[name] = describeFile(written / name);
  }
  return manifest;
}

void flushAllFolders(const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_directory()) flushFolder(entry.path());
  }
  flushFolder(folder);
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder, Kind kind)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0) return;
  const int operation = (kind == Kind::kShared ? LOCK_SH : LOCK_EX) | LOCK_NB;
  const auto deadline = std::chrono::steady_clock::now() + kLockPatience;
  while (flock(descriptor_, operation) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) return;  // the file system knows no locks
    if (std::chrono::steady_clock::now() > deadline) {
      close(descriptor_);
      throw std::runtime_error("map '" + folder.string() +
                               "' is being written by another process, "
                               "or another stage, for " +
                               std::to_string(kLockPatience.count()) + " s");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

fs::path locateFile(const fs::path& folder, const std::string& name) {
  const fs::path ready = folder / kReady / name;
  std::error_code ignored;
  return fs::exists(ready, ignored) ? ready : folder / name;
}

void replaceFiles(const fs::path& folder, const std::optional<ManifestHead>& head,
                  const std::function<OtherFiles(const fs::path&)>& write) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail(folder, error.message());
  const FolderLock lock(folder, FolderLock::Kind::kExclusive);
  moveIntoPlace(folder);
  removeUnfinished(folder);
  const fs::path writing = folder / (kWriting + std::to_string(getpid()));
  const Cleanup cleanup(writing);
  fs::create_directory(writing, error);
  if (error) fail(folder, error.message());
  const OtherFiles others = write(writing);
  writeManifest(writing, makeManifest(writing, head, findManifest(folder), others));
  flushAllFolders(writing);
  moveTo(writing, folder / kReady);
  flushFolder(folder);
  moveIntoPlace(folder);
}

}  // namespace tsg::map
