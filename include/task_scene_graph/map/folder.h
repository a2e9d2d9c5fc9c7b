// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "task_scene_graph/core/frame.h"

/// A map folder as one thing: what is in it changes all at once, and it says what it holds.
namespace tsg::map {

/// Name of the manifest, which every map folder has.
constexpr const char* kManifestName = "map.json";

/// Another map that went into this one.
struct MapSource {
  std::string name;                       ///< its folder
  Pose T_map_source = Pose::Identity();   ///< from its coordinates to those of this map
  std::uint64_t primitive_id_offset = 0;  ///< an id here less that there, of its primitives
  std::uint64_t place_id_offset = 0;      ///< ... and of its places
  std::uint64_t max_primitive_id = 0;     ///< largest id here; its first is the offset + 1
};

/// What a map is, without what is in its files.
struct ManifestHead {
  std::string world_frame;
  std::string model_set;            ///< "" without one
  std::int64_t embedding_size = 0;  ///< D of primitives, places and tasks; 0: none has any
  std::int64_t newest_ns = 0;       ///< stamp of the map
  std::vector<MapSource> sources;   ///< maps merged into it, in that order
};

struct FileRecord {
  std::uint64_t bytes = 0;
  std::uint32_t crc32 = 0;
};

struct Manifest {
  static constexpr int kVersion = 1;

  ManifestHead head;
  std::map<std::string, FileRecord> files;  ///< by name below the folder, with '/'
};

/// Where a file of a map folder lies now: if the process that saved the map was killed while it
/// moved files into place, some are still where they were put ready. O(1).
std::filesystem::path locateFile(const std::filesystem::path& folder, const std::string& name);

/// @throws std::runtime_error naming the file, what was found and what was expected: no folder, no
/// manifest, another version, no JSON, fields that are missing or of the wrong kind, a name that
/// leads out of the folder.
Manifest readManifest(const std::filesystem::path& folder);

/// Checks that the files of a map are there as they were written. @returns names of those that are
/// not but need not be: people and other programs edit scene_graph.json and whatever else is not
/// below `state/`. O(bytes).
/// @throws std::runtime_error naming the first file below `state/` that is missing, or of another
/// size or content.
std::vector<std::string> checkFiles(const std::filesystem::path& folder, const Manifest& manifest);

/// What becomes of files of the map of before that are not written anew.
enum class OtherFiles {
  kRemove,  ///< the folder holds the new map only
  kKeep     ///< they stay part of the map
};

/// Changes what a map folder holds all at once, which is made if it is not there: whenever the
/// process is killed, the map of before is there as a whole, or the new one. Files of others in the
/// folder stay as they are.
///
/// The new files are written into a folder inside it, flushed to the disk, and with one rename of
/// that folder they are the map (locateFile()); then they are moved into place, the manifest last.
/// The disk has to hold both maps for that time. Processes that save into one folder wait for one
/// another.
/// @param head   nullopt: as in the manifest of before
/// @param write  writes files into the folder that it is given, which is empty; says what becomes
/// of the others
/// @throws std::runtime_error naming the path; what `write` throws. Nothing has changed then.
void replaceFiles(const std::filesystem::path& folder, const std::optional<ManifestHead>& head,
                  const std::function<OtherFiles(const std::filesystem::path&)>& write);

}  // namespace tsg::map
