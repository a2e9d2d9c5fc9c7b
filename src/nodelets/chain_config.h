// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "mesh_fusion_config.h"
#include "scene_graph_config.h"
#include "segmenter_config.h"
#include "task_scene_graph/config/config_file.h"
#include "task_scene_graph/config/settings.h"
#include "task_scene_graph/pipeline/pipeline.h"
#include "task_scene_graph/ros/parameters.h"
#include "task_scene_graph/segmentation/model_set.h"
#include "tracker_config.h"

namespace tsg::nodelets {

/// The model set's alpha, where it names one. @throws as segmentation::loadModelSet().
inline std::vector<config::Source> suggestFromModels(const SceneGraphNodeletConfig& config) {
  if (config.models.empty()) return {};
  const auto models = segmentation::loadModelSet(config.models.string());
  YAML::Node suggested(YAML::NodeType::Map);
  suggested["object_alpha"] = models.alpha;
  return {{"model set '" + models.name + "'", suggested, {}}};
}

/// The parameters of the whole chain for programs that run without a parameter server.
struct ChainConfig {
  ros_interface::Loaded<SegmenterNodeletConfig> segmenter;
  ros_interface::Loaded<TrackerNodeletConfig> tracker;
  ros_interface::Loaded<MeshFusionNodeletConfig> mesh_fusion;
  ros_interface::Loaded<SceneGraphNodeletConfig> scene_graph;
};

/// Puts whole configurations together (config/config_file.h), the weakest first: the user's file,
/// then what a command line says in the same layout. @throws config::ConfigError.
inline ChainConfig loadChain(const std::vector<config::Source>& wholes) {
  const auto split = [&](const char* stage, const std::vector<std::string>& names) {
    ros_interface::StageSources sources;
    for (const auto& whole : wholes) {
      for (auto& source : config::splitConfig(whole, stage, names)) {
        sources.given.push_back(std::move(source));
      }
    }
    return sources;
  };
  const auto load = [&](auto& loaded, const auto& suggest) {
    using Config = std::decay_t<decltype(loaded.config)>;
    loaded =
        ros_interface::loadStage<Config>(split(Config::kStage, config::listNames<Config>()),
                                         std::string("parameters of ") + Config::kStage, suggest);
  };
  ChainConfig chain;
  load(chain.segmenter, nullptr);
  load(chain.tracker, nullptr);
  load(chain.mesh_fusion, nullptr);
  load(chain.scene_graph, suggestFromModels);
  return chain;
}

/// The stages' settings in the order of the chain.
inline std::vector<config::StageSettings> listSettings(const ChainConfig& chain) {
  const auto list = [](const auto& loaded) {
    using Config = std::decay_t<decltype(loaded.config)>;
    return config::StageSettings{Config::kStage,
                                 config::listSettings(loaded.config, loaded.origins)};
  };
  return {list(chain.segmenter), list(chain.tracker), list(chain.mesh_fusion),
          list(chain.scene_graph)};
}

/// What of the parameters the pipeline takes.
inline pipeline::PipelineConfig toPipelineConfig(const ChainConfig& chain) {
  pipeline::PipelineConfig config;
  config.segmenter = chain.segmenter.config.segmenter;
  config.tracker = chain.tracker.config.tracker;
  config.mesh_fusion.background_fusion = chain.mesh_fusion.config.background_fusion;
  config.mesh_fusion.object_fusion = chain.mesh_fusion.config.object_fusion;
  config.scene_graph = chain.scene_graph.config.scene_graph;
  return config;
}

}  // namespace tsg::nodelets
