// SPDX-License-Identifier: BSD-3-Clause
#include "map_services.h"

#include <ros/console.h>
#include <ros/names.h>
#include <ros/service.h>
#include <task_scene_graph/SaveMapPart.h>

#include <algorithm>
#include <iomanip>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "task_scene_graph/core/scratch_folder.h"
#include "task_scene_graph/loops/map_alignment.h"
#include "task_scene_graph/map/merge.h"
#include "task_scene_graph/map/settings.h"
#include "task_scene_graph/ros/geometry_conversions.h"

namespace tsg::nodelets {
namespace {

namespace fs = std::filesystem;
using ros_interface::FlushedStages;
using ros_interface::Patience;
using scene_graph::SceneGraphBuilder;

// Of save_map, and of what follows a map that was loaded.
constexpr double kSaveTimeout_s = 60.0;
constexpr double kSaveQuiet_s = 15.0;

// Stages start one after the other, and the first frames of one may be before those of the next.
constexpr double kStart_s = 5.0;

/// Runs something at the end of its life, whatever happens.
class AtEnd {
 public:
  explicit AtEnd(std::function<void()> action) : action_(std::move(action)) {}
  ~AtEnd() { action_(); }
  AtEnd(const AtEnd&) = delete;
  AtEnd& operator=(const AtEnd&) = delete;

 private:
  std::function<void()> action_;
};

/// When the first thing was seen; `otherwise` if there is none.
Stamp findFirstSeen(const map::Map& map, Stamp otherwise) {
  Stamp first = otherwise;
  for (const auto& primitive : map.primitives()) first = std::min(first, primitive->first_seen);
  return first;
}

/// What has come since a map was loaded into the stage before: kept beside the map.
struct NewerThings {
  std::vector<ObjectPrimitivePtr> primitives;
  PlaceGraphPtr places;
};

NewerThings findNewer(const SceneGraphBuilder& builder, const map::Map& map) {
  NewerThings newer;
  for (const auto& primitive : builder.primitives()) {
    if (map.findPrimitive(primitive->id) == nullptr) newer.primitives.push_back(primitive);
  }
  newer.places = builder.places();
  return newer;
}

}  // namespace

MapServices::MapServices(ros::NodeHandle& services, Options options, GraphAccess access,
                         Callbacks callbacks)
    : options_(std::move(options)), access_(std::move(access)), callbacks_(std::move(callbacks)) {
  servers_.push_back(services.advertiseService("save_map", &MapServices::serveSave, this));
  servers_.push_back(services.advertiseService("load_map", &MapServices::serveLoad, this));
  servers_.push_back(services.advertiseService("merge_map", &MapServices::serveMerge, this));
}

void MapServices::setSources(std::vector<map::MapSource> sources) {
  const std::lock_guard<std::mutex> lock(sources_mutex_);
  sources_ = std::move(sources);
}

map::Map MapServices::makeMap(SceneGraphBuilder& builder) const {
  map::Map map = map::makeMap(builder);
  map::MapSettings settings = map.settings();
  settings.model_set = options_.model_set;
  settings.stages = callbacks_.settings();
  settings.record = {{"program", config::quoteYaml("live, " + options_.name), ""},
                     {"model_set", config::quoteYaml(options_.model_set), ""}};
  map.setSettings(std::move(settings));
  const std::lock_guard<std::mutex> lock(sources_mutex_);
  map.setSources(sources_);
  return map;
}

map::Map MapServices::takeMap() const {
  map::Map map;
  access_.run([&](SceneGraphBuilder& builder) { map = makeMap(builder); });
  return map;
}

std::vector<WrittenFile> MapServices::save(bool is_end, FlushedStages& flushed) {
  return write(options_.output, takeMap(), is_end, flushed);
}

std::vector<WrittenFile> MapServices::saveGraph(SceneGraphBuilder& builder) {
  const map::Map map = makeMap(builder);
  std::vector<WrittenFile> files;
  map::replaceFiles(options_.output, map::describeMap(map), [&](const fs::path& to) {
    files = map::writeGraphPart(to, map);
    return map::OtherFiles::kKeep;
  });
  return files;
}

std::vector<WrittenFile> MapServices::write(const fs::path& folder, const map::Map& map,
                                            bool is_end, FlushedStages& flushed) const {
  if (map.isEmpty()) throw std::runtime_error(callbacks_.explainEmpty());
  std::vector<WrittenFile> files;
  map::replaceFiles(folder, map::describeMap(map), [&](const fs::path& to) {
    files = map::writeGraphPart(to, map);
    const auto background = writeBackground(to, map, is_end, flushed);
    files.insert(files.end(), background.begin(), background.end());
    return background.empty() ? map::OtherFiles::kKeep : map::OtherFiles::kRemove;
  });
  files.push_back({"state", "to go on from"});
  files.push_back({map::kManifestName, ""});
  return files;
}

std::vector<WrittenFile> MapServices::writeBackground(const fs::path& folder, const map::Map& map,
                                                      bool is_end, FlushedStages& flushed) const {
  if (options_.upstream.empty()) return {};
  const std::string stage = options_.upstream.back();
  const std::string service = ros::names::append(stage, "save_map_part");
  if (!ros::service::exists(service, false)) {
    if (callbacks_.knows(stage)) flushed.missing.push_back(stage + ": has ended; its files stay");
    return {};
  }
  msg::SaveMapPart call;
  call.request.folder = fs::absolute(folder).string();
  call.request.is_end = is_end ? 1 : 0;
  for (const auto& [primitive, object] :
       scene_graph::computeObjectOfPrimitives(map::computeSceneGraph(map))) {
    call.request.primitives.push_back(primitive.value);
    call.request.objects.push_back(object);
  }
  if (!ros::service::call(service, call) || call.response.success == 0) {
    const std::string& why = call.response.message;
    flushed.missing.push_back(service + ": " + (why.empty() ? "the call failed" : why));
    return {};
  }
  const Stamp since = ros_interface::toStamp(call.response.since);
  const double missing_s = secondsBetween(findFirstSeen(map, since), since);
  if (missing_s > kStart_s) {
    std::ostringstream text;
    text << std::fixed << std::setprecision(1) << stage
         << ": was started anew; mesh, places, trajectory and grids lack the first " << missing_s
         << " s of the map, up to " << since.seconds() << " s";
    flushed.missing.push_back(text.str());
  }
  std::vector<WrittenFile> files;
  for (std::size_t i = 0; i < call.response.files.size(); ++i) {
    files.push_back({call.response.files[i], call.response.contents[i]});
  }
  return files;
}

bool MapServices::serveSave(std_srvs::TriggerRequest&, std_srvs::TriggerResponse& response) {
  try {
    if (options_.output.empty()) throw std::runtime_error("parameter 'output' is not set");
    auto flushed =
        callbacks_.flush(msg::FlushRequest::SNAPSHOT, Patience::from(kSaveTimeout_s, kSaveQuiet_s));
    const std::vector<WrittenFile> files = save(false, flushed);
    ROS_INFO_STREAM("[" << options_.name << "] " << describeWritten(options_.output, files));
    response.message = options_.output.string();
    for (const auto& line : flushed.contents) response.message += "\n" + line;
    for (const auto& line : flushed.missing) {
      response.message += "\nmissing: " + line;
      callbacks_.warn("save_map: missing: " + line);
    }
    response.success = flushed.missing.empty() ? 1 : 0;
  } catch (const std::exception& e) {
    response.message = std::string("no map was written: ") + e.what();
    response.success = 0;
    ROS_ERROR_STREAM("[" << options_.name << "] " << response.message);
  }
  return true;
}

map::LoadedMap MapServices::read(const fs::path& folder, Eigen::Index embedding_size) const {
  map::MapUse use;
  use.world_frame = options_.world_frame;
  use.model_set = options_.model_set;
  use.embedding_size = embedding_size;
  return map::loadMap(folder, use);
}

bool MapServices::serveLoad(msg::LoadMapRequest& request, msg::LoadMapResponse& response) {
  try {
    load(request, response);
    response.message = describeNow();
    response.success = 1;
    ROS_INFO_STREAM("[" << options_.name << "] loaded '" << request.folder
                        << "': " << response.message);
    for (const auto& note : response.notes) callbacks_.warn("load_map: " + note);
  } catch (const std::exception& e) {
    response.message = std::string("map not loaded: ") + e.what();
    response.success = 0;
    ROS_ERROR_STREAM("[" << options_.name << "] " << response.message);
  }
  return true;
}

/// Whatever can be wrong with the files is found before anything changes.
void MapServices::load(const msg::LoadMapRequest& request, msg::LoadMapResponse& response) {
  const fs::path folder = expandPath(request.folder);
  Eigen::Index embedding_size = 0;
  if (request.with_tasks == 0) {
    access_.run([&](SceneGraphBuilder& builder) {
      embedding_size =
          std::max(builder.objectTasks().embeddings.cols(), builder.placeTasks().embeddings.cols());
    });
  }
  const map::LoadedMap loaded = read(folder, embedding_size);
  response.notes = loaded.notes;
  callbacks_.setLoading(true);
  const AtEnd end([this] { callbacks_.setLoading(false); });
  loadUpstream(folder, response);
  restore(loaded.map, request.with_tasks != 0);
  setSources(loaded.map.sources());
}

/// mesh_fusion loads its part; then the stages before it forget what they saw before.
void MapServices::loadUpstream(const fs::path& folder, msg::LoadMapResponse& response) const {
  for (auto stage = options_.upstream.rbegin(); stage != options_.upstream.rend(); ++stage) {
    if (ros::service::exists(ros::names::append(*stage, "load_map"), false)) {
      loadStage(*stage, folder, response);
      continue;
    }
    const std::string reset = ros::names::append(*stage, "reset");
    std_srvs::Trigger call;
    if (ros::service::exists(reset, false) && !ros::service::call(reset, call)) {
      response.notes.push_back(reset + " failed");
    }
  }
}

void MapServices::loadStage(const std::string& stage, const fs::path& folder,
                            msg::LoadMapResponse& response) const {
  msg::LoadMap call;
  call.request.folder = fs::absolute(folder).string();
  if (!ros::service::call(ros::names::append(stage, "load_map"), call)) {
    throw std::runtime_error(stage + " has ended");
  }
  if (call.response.success == 0) throw std::runtime_error(call.response.message);
  const auto patience = Patience::from(kSaveTimeout_s, kSaveQuiet_s);
  if (callbacks_.waitFor(call.response.sequence, call.response.place_sequence, patience)) return;
  response.notes.push_back("the messages of " + stage + " are late: it is still at work");
}

void MapServices::restore(const map::Map& map, bool with_tasks) const {
  access_.run([&](SceneGraphBuilder& builder) {
    const NewerThings newer = findNewer(builder, map);
    builder.reset();
    if (with_tasks) {
      builder.setObjectTasks(map.objectTasks());
      builder.setPlaceTasks(map.placeTasks());
    }
    const auto update = map::restoreBuilder(map, builder);
    if (!update.error.empty()) callbacks_.warn("load_map: left out: " + update.error);
    if (!options_.upstream.empty() && !newer.places->places.empty()) {
      builder.setPlaces(newer.places);
    }
    builder.addPrimitives(newer.primitives);
    callbacks_.setLoading(false);
  });
}

bool MapServices::serveMerge(msg::MergeMapRequest& request, msg::MergeMapResponse& response) {
  const bool was_paused = callbacks_.isPaused();
  try {
    if (!was_paused) callbacks_.setPaused(true);
    const AtEnd end([&] {
      if (!was_paused) callbacks_.setPaused(false);
    });
    const std::string how = merge(request);
    response.message = describeNow() + (how.empty() ? "" : "; " + how);
    response.success = 1;
    ROS_INFO_STREAM("[" << options_.name << "] merged with '" << request.folder
                        << "': " << response.message);
  } catch (const std::exception& e) {
    response.message = std::string("maps not merged: ") + e.what();
    response.success = 0;
    ROS_ERROR_STREAM("[" << options_.name << "] " << response.message);
  }
  return true;
}

/// Through files: the map of now is in two processes, or may be. Returns how the transform was
/// found, if it was looked for.
std::string MapServices::merge(const msg::MergeMapRequest& request) {
  if (request.align != 0 && request.has_transform != 0) {
    throw std::invalid_argument("align and has_transform are both set, expected one of them");
  }
  map::readManifest(expandPath(request.folder));
  const ScratchFolder scratch;
  auto flushed =
      callbacks_.flush(msg::FlushRequest::SNAPSHOT, Patience::from(kSaveTimeout_s, kSaveQuiet_s));
  const fs::path current = scratch.path() / "current";
  write(current, takeMap(), false, flushed);
  if (!flushed.missing.empty()) {
    throw std::runtime_error("the map of now is not complete: " + flushed.missing.front());
  }
  const fs::path merged = scratch.path() / "merged";
  std::string how;
  map::writeMap(merged, mergeFiles(request, current, how));
  msg::LoadMapRequest load_request;
  load_request.folder = merged.string();
  msg::LoadMapResponse load_response;
  load(load_request, load_response);
  return how;
}

map::Map MapServices::mergeFiles(const msg::MergeMapRequest& request, const fs::path& current,
                                 std::string& how) const {
  map::MergeOptions options;
  options.is_transform_given = request.has_transform != 0 || request.align != 0;
  if (request.has_transform != 0) options.T_a_b = ros_interface::toPose(request.transform);
  options.name_b = request.folder;
  map::LoadedMap now = map::loadMap(current);
  options.places = map::readSettings<places::PlacesConfig>(current, "mesh_fusion", "places");
  map::MapUse use;
  use.model_set = options_.model_set;
  use.embedding_size = now.map.embeddingSize();
  if (!options.is_transform_given) use.world_frame = options_.world_frame;
  const map::LoadedMap other = map::loadMap(expandPath(request.folder), use);
  if (request.align != 0) {
    const loops::MapAlignment found = loops::alignMaps(now.map, other.map);
    options.T_a_b = found.T_a_b;
    how = loops::toText(found);
  }
  return map::mergeMaps(now.map, other.map, options);
}

std::string MapServices::describeNow() const {
  const scene_graph::SceneGraphPtr graph = access_.graph();
  if (graph == nullptr) return "nothing";
  return formatCount(graph->primitives.size(), "primitive") + ", " +
         formatCount(graph->objects.size(), "object") + ", " +
         formatCount(graph->places->places.size(), "place") + ", " +
         formatCount(graph->regions.size(), "region");
}

}  // namespace tsg::nodelets
