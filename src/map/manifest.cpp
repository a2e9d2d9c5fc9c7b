// SPDX-License-Identifier: BSD-3-Clause
// What a map folder says of itself.
#include "manifest.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "task_scene_graph/core/binary.h"
#include "task_scene_graph/core/files.h"

namespace tsg::map {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;

constexpr const char* kFormat = "task_scene_graph map";
constexpr std::size_t kMaxManifestBytes = std::size_t{1} << 28;

Json toJson(const Pose& pose) {
  const Eigen::Quaterniond q(pose.linear());
  const Eigen::Vector3d& t = pose.translation();
  return {{"translation_m", {t.x(), t.y(), t.z()}},
          {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}}};
}

Pose toPose(const Json& json) {
  const Json& t = json.at("translation_m");
  const Json& q = json.at("rotation_xyzw");
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(t.at(0), t.at(1), t.at(2));
  pose.linear() = Eigen::Quaterniond(q.at(3), q.at(0), q.at(1), q.at(2)).normalized().matrix();
  if (!pose.matrix().allFinite()) throw std::runtime_error("a transform is not finite");
  return pose;
}

Json toJson(const MapSource& source) {
  return {{"name", source.name},
          {"T_map_source", toJson(source.T_map_source)},
          {"primitive_id_offset", source.primitive_id_offset},
          {"place_id_offset", source.place_id_offset},
          {"max_primitive_id", source.max_primitive_id}};
}

MapSource toSource(const Json& json) {
  return {json.at("name").get<std::string>(), toPose(json.at("T_map_source")),
          json.at("primitive_id_offset").get<std::uint64_t>(),
          json.at("place_id_offset").get<std::uint64_t>(),
          json.at("max_primitive_id").get<std::uint64_t>()};
}

void requireInside(const std::string& name) {
  const fs::path path = fs::path(name).lexically_normal();
  const bool is_inside = !name.empty() && !path.is_absolute() && *path.begin() != "..";
  if (!is_inside) throw std::runtime_error("file '" + name + "' is not below the folder");
}

void requireVersion(const Json& json) {
  if (!json.is_object() || json.value("format", "") != kFormat) {
    throw std::runtime_error(std::string("is no manifest of a map, expected \"format\": \"") +
                             kFormat + "\"");
  }
  const Json& version = json.at("version");
  if (version == Manifest::kVersion) return;
  throw std::runtime_error("is of version " + version.dump() + ", expected " +
                           std::to_string(Manifest::kVersion) +
                           ": it was written by another version of this package");
}

Manifest parse(const std::string& text) {
  const Json json = Json::parse(text);
  requireVersion(json);
  Manifest manifest;
  manifest.head.world_frame = json.at("frame").get<std::string>();
  manifest.head.model_set = json.at("model_set").get<std::string>();
  manifest.head.embedding_size = json.at("embedding_size").get<std::int64_t>();
  manifest.head.newest_ns = json.at("newest_ns").get<std::int64_t>();
  for (const Json& source : json.at("sources")) manifest.head.sources.push_back(toSource(source));
  for (const auto& [name, record] : json.at("files").items()) {
    requireInside(name);
    manifest.files[name] = {record.at("bytes").get<std::uint64_t>(),
                            record.at("crc32").get<std::uint32_t>()};
  }
  return manifest;
}

/// Brackets in brackets would overflow the parser's stack.
void requireFlat(const std::string& text) {
  int depth = 0;
  for (const char c : text) {
    depth += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
    if (depth > 100) throw std::runtime_error("is nested more than 100 deep");
  }
}

bool mayDiffer(const std::string& name) { return name.rfind(kStateFolder, 0) != 0; }

}  // namespace

FileRecord describeFile(const fs::path& path) {
  return {static_cast<std::uint64_t>(fs::file_size(path)), computeCrc32(path)};
}

void writeManifest(const fs::path& folder, const Manifest& manifest) {
  Json json = {{"format", kFormat},
               {"version", Manifest::kVersion},
               {"frame", manifest.head.world_frame},
               {"model_set", manifest.head.model_set},
               {"embedding_size", manifest.head.embedding_size},
               {"newest_ns", manifest.head.newest_ns},
               {"sources", Json::array()},
               {"files", Json::object()}};
  for (const MapSource& source : manifest.head.sources) json["sources"].push_back(toJson(source));
  for (const auto& [name, record] : manifest.files) {
    json["files"][name] = {{"bytes", record.bytes}, {"crc32", record.crc32}};
  }
  writeFileAtomically(folder / kManifestName, [&](std::ostream& out) {
    out << json.dump(1, ' ', false, Json::error_handler_t::replace) << '\n';
  });
}

Manifest readManifestFile(const fs::path& path) {
  try {
    requireFile("file", path);
    if (fs::file_size(path) > kMaxManifestBytes) throw std::runtime_error("is too large");
    std::ifstream stream(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    requireFlat(text);
    return parse(text);
  } catch (const std::exception& e) {
    throw std::runtime_error("map's file '" + path.string() + "' " + e.what());
  }
}

Manifest readManifest(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw std::runtime_error("map '" + folder.string() + "' is not there, expected a folder");
  }
  const fs::path path = locateFile(folder, kManifestName);
  if (!fs::exists(path)) {
    throw std::runtime_error("map '" + folder.string() + "' has no " + kManifestName +
                             ": expected a folder that save_map or process_bag has written");
  }
  return readManifestFile(path);
}

std::vector<std::string> checkFiles(const fs::path& folder, const Manifest& manifest) {
  std::vector<std::string> edited;
  for (const auto& [name, record] : manifest.files) {
    const fs::path path = locateFile(folder, name);
    const bool is_there = fs::is_regular_file(path);
    const std::uint64_t bytes = is_there ? fs::file_size(path) : 0;
    if (is_there && bytes == record.bytes && computeCrc32(path) == record.crc32) continue;
    if (mayDiffer(name)) {
      edited.push_back(name);
      continue;
    }
    const std::string which = "map's file '" + path.string() + "' ";
    if (!is_there) throw std::runtime_error(which + "is not there, but in " + kManifestName);
    throw std::runtime_error(which + "is damaged: " + std::to_string(bytes) +
                             " bytes that are not the " + std::to_string(record.bytes) +
                             " written (" + kManifestName + ")");
  }
  return edited;
}

}  // namespace tsg::map
