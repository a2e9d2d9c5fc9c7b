// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/bottleneck/explanation.h"

/// What the clustering says of itself, in words for people.
namespace tsg::scene_graph {

/// What is clustered, for the words: {"primitive", "object"} or {"place", "region"}.
struct ClusterWords {
  std::string member;
  std::string cluster;
};

/// How a cluster came to be: its task, its merges, and the one that was not made.
/// @param tasks  names in the order of y = 1, 2, ...
std::string describeExplanation(const bottleneck::ClusterExplanation& explanation,
                                const std::vector<std::string>& tasks, const ClusterWords& words);

/// Why two members are, or are not, in one cluster.
std::string describeExplanation(const bottleneck::PairExplanation& explanation, std::uint64_t a,
                                std::uint64_t b, const std::vector<std::string>& tasks,
                                const ClusterWords& words);

/// What a member serves: its cosines, best first, and p(y|x).
std::string describeExplanation(const bottleneck::PrimitiveExplanation& explanation,
                                const std::vector<std::string>& tasks, const ClusterWords& words);

}  // namespace tsg::scene_graph
