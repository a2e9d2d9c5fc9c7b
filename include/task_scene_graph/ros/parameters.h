// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>
#include <yaml-cpp/yaml.h>

#include <functional>
#include <string>
#include <vector>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/ros/frame_names.h"

/// Where the parameters of a stage come from, weakest first:
///
/// 1. the defaults of its configuration struct;
/// 2. the package's own file (`default_config_file`, set by the launch file);
/// 3. what the model set suggests;
/// 4. the user's file (`config_file`), which the stage reads itself, so that the same text is the
///    same value live and offline;
/// 5. the parameter server: launch arguments that were given, and what a user put there.
///
/// In 2, 4 and 5 what all stages share (`input`) is weaker than the stage's own section. The two
/// file names are private parameters, or lie in the namespace that the stages share. Nothing here
/// is ever written to the parameter server: no run changes the next.
namespace tsg::ros_interface {

/// A ROS parameter as YAML. Numbers keep every digit, and numbers and booleans carry a tag, since
/// they are no strings (config/scalar.h). @throws std::invalid_argument for types that YAML
/// configurations do not have (dates, binary data).
YAML::Node toYaml(XmlRpc::XmlRpcValue value);

/// Sources of a stage's parameters, each weakest first. The model set's suggestions lie between.
struct StageSources {
  std::vector<config::Source> packaged;
  std::vector<config::Source> given;
};

/// Reads all sources of the nodelet with this private node handle.
/// @param stage  its section in configuration files
/// @param names  the parameters that it has
/// @throws config::ConfigError naming the parameter or the file.
StageSources readSources(const ::ros::NodeHandle& private_handle, const std::string& stage,
                         const std::vector<std::string>& names);

/// A configuration and where its values come from.
template <typename Config>
struct Loaded {
  Config config;
  config::Origins origins;
};

/// What a configuration, read without it, suggests for itself: the model set that it names.
template <typename Config>
using Suggest = std::function<std::vector<config::Source>(const Config&)>;

/// Puts the sources of one stage together. Names of frames lose a leading slash. @throws
/// config::ConfigError with all violations, each naming the parameter and its source: unknown names
/// (with the nearest known one), wrong types, values out of range.
template <typename Config>
Loaded<Config> loadStage(const StageSources& sources, const std::string& where,
                         const Suggest<Config>& suggest = nullptr) {
  const auto join = [&](const std::vector<config::Source>& suggested) {
    std::vector<config::Source> all = sources.packaged;
    all.insert(all.end(), suggested.begin(), suggested.end());
    all.insert(all.end(), sources.given.begin(), sources.given.end());
    return all;
  };
  Loaded<Config> loaded;
  loaded.config = config::load(join({}), where, Config{}, &loaded.origins);
  if (suggest) {
    const auto suggested = suggest(loaded.config);
    loaded.config = config::load(join(suggested), where, Config{}, &loaded.origins);
  }
  FrameNameCleaner cleaner;
  Config::visit(loaded.config, cleaner);
  return loaded;
}

/// Reads a nodelet's parameters out of all sources. `Config::kStage` names its section.
/// @throws config::ConfigError as loadStage().
template <typename Config>
Loaded<Config> loadParameters(const ::ros::NodeHandle& private_handle,
                              const Suggest<Config>& suggest = nullptr) {
  return loadStage<Config>(readSources(private_handle, Config::kStage, config::listNames<Config>()),
                           "parameters of " + private_handle.getNamespace(), suggest);
}

}  // namespace tsg::ros_interface
