// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "task_scene_graph/core/box.h"
#include "task_scene_graph/core/embedding.h"

namespace tsg::bottleneck {

/// @throws std::runtime_error saying what is wrong with `bounding_box`.
Aabb readBox(const nlohmann::json& attributes);
/// @throws std::runtime_error saying what is wrong with `semantic_feature`.
Embedding readEmbedding(const nlohmann::json& attributes);
/// @throws std::runtime_error saying what is wrong with `position`.
Eigen::Vector3d readPosition(const nlohmann::json& attributes);

/// Attributes of one node that stands for all of `members` (not empty), of the first one's type.
/// What has no meaningful union is the first one's.
nlohmann::json mergeAttributes(const std::vector<const nlohmann::json*>& members);

}  // namespace tsg::bottleneck
