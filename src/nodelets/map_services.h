// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>
#include <task_scene_graph/LoadMap.h>
#include <task_scene_graph/MergeMap.h>

#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "graph_access.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/ros/flush.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::nodelets {

/// The map as a whole: services `~save_map`, `~load_map`, `~merge_map`. The one owner of saving:
/// it has the chain flushed, writes what the graph knows, and has mesh_fusion write the rest into
/// the same folder, which becomes the map all at once.
class MapServices {
 public:
  struct Options {
    std::string name;                   ///< of the stage, for messages
    std::filesystem::path output;       ///< empty: none
    std::vector<std::string> upstream;  ///< resolved names, in the order of the chain
    std::string world_frame;
    std::string model_set;  ///< "" without one
  };
  struct Callbacks {
    /// Has the chain work off what it has, and says what is missing.
    std::function<ros_interface::FlushedStages(std::uint8_t, const ros_interface::Patience&)> flush;
    std::function<std::vector<config::StageSettings>()> settings;  ///< of all stages
    std::function<bool(const std::string&)> knows;  ///< a stage that is there, or was
    std::function<void(const std::string&)> warn;
    std::function<std::string()> explainEmpty;  ///< why there is no map
    /// Waits for these messages of mesh_fusion: of primitives, of places. False if they stay away.
    std::function<bool(std::uint64_t, std::uint64_t, const ros_interface::Patience&)> waitFor;
    /// While a map is loaded nothing is published. From any thread.
    std::function<void(bool)> setLoading;
    std::function<std::string(bool)> setPaused;  ///< of the whole chain
    std::function<bool()> isPaused;
  };

  /// @param services  whose callbacks run in a thread of their own, one at a time
  MapServices(ros::NodeHandle& services, Options options, GraphAccess access, Callbacks callbacks);

  /// Writes the map of now into `output`, as save_map does after flushing. Problems with the
  /// background are added to `flushed`. @throws std::runtime_error if there is no map, or it cannot
  /// be written: the one before stays.
  std::vector<WrittenFile> save(bool is_end, ros_interface::FlushedStages& flushed);
  /// Writes what the graph knows, once there is no other stage any more; the background's files of
  /// before stay. @throws as save().
  std::vector<WrittenFile> saveGraph(scene_graph::SceneGraphBuilder& builder);

  /// Reads a map that fits what is used here. @param embedding_size  of the tasks; 0: any
  /// @throws as map::loadMap().
  map::LoadedMap read(const std::filesystem::path& folder, Eigen::Index embedding_size) const;
  /// Tells of what went into a map that was loaded; of a new one nothing.
  void setSources(std::vector<map::MapSource> sources);

 private:
  bool serveSave(std_srvs::TriggerRequest& request, std_srvs::TriggerResponse& response);
  bool serveLoad(msg::LoadMapRequest& request, msg::LoadMapResponse& response);
  bool serveMerge(msg::MergeMapRequest& request, msg::MergeMapResponse& response);
  map::Map makeMap(scene_graph::SceneGraphBuilder& builder) const;
  map::Map takeMap() const;
  std::vector<WrittenFile> write(const std::filesystem::path& folder, const map::Map& map,
                                 bool is_end, ros_interface::FlushedStages& flushed) const;
  std::vector<WrittenFile> writeBackground(const std::filesystem::path& folder, const map::Map& map,
                                           bool is_end,
                                           ros_interface::FlushedStages& flushed) const;
  void load(const msg::LoadMapRequest& request, msg::LoadMapResponse& response);
  void loadUpstream(const std::filesystem::path& folder, msg::LoadMapResponse& response) const;
  void loadStage(const std::string& stage, const std::filesystem::path& folder,
                 msg::LoadMapResponse& response) const;
  void restore(const map::Map& map, bool with_tasks) const;
  std::string merge(const msg::MergeMapRequest& request);
  map::Map mergeFiles(const msg::MergeMapRequest& request, const std::filesystem::path& current,
                      std::string& how) const;
  std::string describeNow() const;

  Options options_;
  GraphAccess access_;
  Callbacks callbacks_;
  mutable std::mutex sources_mutex_;  ///< guards the next
  std::vector<map::MapSource> sources_;
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace tsg::nodelets
