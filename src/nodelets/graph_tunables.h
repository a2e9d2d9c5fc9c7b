// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <task_scene_graph/SceneGraphTuningConfig.h>
#include <yaml-cpp/yaml.h>

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/config/settings.h"
#include "task_scene_graph/ros/reconfigure_server.h"
#include "task_scene_graph/ros/scene_graph_markers.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/scene_graph/config.h"

/// What dynamic_reconfigure may change of the scene graph stage.
namespace tsg::nodelets {

using Tunables = ::task_scene_graph::SceneGraphTuningConfig;  // from cfg/SceneGraphTuning.cfg

struct TunedConfig {
  scene_graph::SceneGraphConfig graph;
  ros_interface::MarkerConfig markers;
};

/// Copies the numbers among them, in either direction.
template <typename From, typename To>
void copyNumbers(const From& from, To& to) {
  to.object_alpha = from.object_alpha;
  to.object_delta = from.object_delta;
  to.object_top_k = from.object_top_k;
  to.object_delta_bits = from.object_delta_bits;
  to.place_alpha = from.place_alpha;
  to.place_delta = from.place_delta;
  to.place_top_k = from.place_top_k;
  to.place_delta_bits = from.place_delta_bits;
  to.place_smoothing_per_m = from.place_smoothing_per_m;
  to.min_region_places = from.min_region_places;
  to.prune_null = from.prune_null;
  to.min_object_score = from.min_object_score;
}

inline Tunables toTunables(const TunedConfig& config) {
  Tunables tunables = Tunables::__getDefault__();
  copyNumbers(config.graph, tunables);
  std::map<std::string, std::string> names;
  for (const auto& setting : config::listSettings(config.graph, {})) {
    names[setting.name] = YAML::Load(setting.value).as<std::string>();
  }
  tunables.object_normaliser = names["object_normaliser"];
  tunables.place_normaliser = names["place_normaliser"];
  tunables.region_method = names["region_method"];
  tunables.prior = names["prior"];
  tunables.markers_object_lift_m = config.markers.object_lift_m;
  tunables.markers_place_lift_m = config.markers.place_lift_m;
  tunables.markers_region_lift_m = config.markers.region_lift_m;
  tunables.markers_text_height_m = config.markers.text_height_m;
  tunables.markers_label_distance_m = config.markers.label_distance_m;
  return tunables;
}

/// @param base   what cannot be tuned is taken from it
/// @param where  for the error
/// @throws config::ConfigError naming each value out of range and each choice that is none.
inline TunedConfig fromTunables(const Tunables& tunables, TunedConfig base,
                                const std::string& where) {
  copyNumbers(tunables, base.graph);
  YAML::Node choices;
  choices["object_normaliser"] = tunables.object_normaliser;
  choices["place_normaliser"] = tunables.place_normaliser;
  choices["region_method"] = tunables.region_method;
  choices["prior"] = tunables.prior;
  base.graph = config::load(choices, where, base.graph);
  base.markers.object_lift_m = tunables.markers_object_lift_m;
  base.markers.place_lift_m = tunables.markers_place_lift_m;
  base.markers.region_lift_m = tunables.markers_region_lift_m;
  base.markers.text_height_m = tunables.markers_text_height_m;
  base.markers.label_distance_m = tunables.markers_label_distance_m;
  config::validate(base.graph, where);
  config::validate(base.markers, where);
  return base;
}

using TunablesServer = ros_interface::ReconfigureServer<Tunables>;

/// Serves them to dynamic_reconfigure's clients.
/// @param handle   of the stage
/// @param initial  what is in force; what cannot be tuned stays so
/// @param accept   puts values in force that are within their ranges
/// @param report   is told what was refused; must outlive the server
inline std::unique_ptr<TunablesServer> serveTunables(
    const ros::NodeHandle& handle, const TunedConfig& initial,
    const std::function<void(const TunedConfig&)>& accept, ros_interface::StageReport& report) {
  return std::make_unique<TunablesServer>(
      handle, toTunables(initial),
      TunablesServer::Callbacks{
          [initial, accept, where = handle.getNamespace()](const Tunables& tunables) {
            accept(fromTunables(tunables, initial, where));
          },
          [&report](const std::string& problem) { report.warn(problem, problem); }});
}

}  // namespace tsg::nodelets
