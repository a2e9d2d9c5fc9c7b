// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "task_scene_graph/config/config.h"

/// Configuration files as people write them, for all programs alike:
///
///     input: {world_frame: map}     shared: for every stage that has a parameter of this name,
///     models: ~/models/clip.yaml    unless the stage's own section says otherwise
///     output: ~/map
///     tracker:                      one section for each stage
///       window_s: 3.0
///
/// A file `settings.yaml` out of a map folder is one, too.
namespace tsg::config {

/// The stages, in the order of the chain.
const std::vector<std::string>& listStages();

/// Reads a configuration file. Relative paths in it begin at its folder.
/// @param path  empty gives an empty source
/// @throws ConfigError naming the file if it cannot be read, is no map, or has a key that is
/// neither shared nor a stage, with the nearest known one.
Source readConfigFile(const std::filesystem::path& path);

/// What a configuration holds for one stage, later sources win: what is shared, then the stage's
/// own section. @param names  parameters that the stage has; what is shared otherwise is left out
std::vector<Source> splitConfig(const Source& whole, const std::string& stage,
                                const std::vector<std::string>& names);

/// What is shared in a configuration, for a stage that has the parameters `names`. Stages without a
/// group `input` that have a parameter `world_frame` get that of `input`.
Source pickShared(const Source& whole, const std::vector<std::string>& names);

}  // namespace tsg::config
