// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "task_scene_graph/plausibility/finding.h"
#include "task_scene_graph/scene_graph/builder.h"
#include "task_scene_graph/scene_graph/scene_graph.h"
#include "task_scene_graph/scene_graph/scoring.h"
#include "task_scene_graph/tracking/tracker.h"

namespace tsg::plausibility {

/// What a list of tasks was compared with, and the threshold.
struct CosineContext {
  std::string things = "primitive";        ///< or "place"
  std::string parameter = "object_alpha";  ///< of scene_graph; or "place_alpha"
  double alpha = 0.23;                     ///< its value
  std::vector<std::string> tasks;          ///< their names
  std::size_t num_served = 0;              ///< objects, or regions with a name
  std::size_t things_alike = 1;            ///< so many stand close together and look alike
};

/// Of the objects and of the regions of a graph.
CosineContext makeObjectContext(const scene_graph::SceneGraph& graph);
CosineContext makePlaceContext(const scene_graph::SceneGraph& graph);

/// Cosines beside alpha, from 5 things with an embedding on (things_alike times as many):
/// - "no tasks": the list is empty;
/// - "cosines" / "place cosines": nothing is served and the highest cosine is below alpha; or (from
///   20 on) the lowest is above alpha by 0.15, so that nothing is ever irrelevant.
std::optional<Finding> checkCosines(const scene_graph::CosineSummary& cosines,
                                    const CosineContext& context);

/// checkCosines() of a builder and the graph that it has made last, objects and regions. Tasks that
/// are absent are left out: who reads their file says so.
std::vector<Finding> checkGraph(const scene_graph::SceneGraphBuilder& builder,
                                const scene_graph::SceneGraph& graph);

/// "tracker cosines": of 100 or more segments that overlap a track enough, most are refused by
/// their cosine alone.
std::optional<Finding> checkTracker(const tracking::TrackerCounters& counters,
                                    const tracking::TrackerConfig& config);

}  // namespace tsg::plausibility
