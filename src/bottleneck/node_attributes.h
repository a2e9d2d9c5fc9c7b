// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "node_box.h"
#include "task_scene_graph/core/embedding.h"

namespace tsg::bottleneck {

/// Mean of the columns of `semantic_feature`; finite and not zero.
/// @throws std::runtime_error saying what is wrong with it.
Embedding readEmbedding(const nlohmann::json& attributes);
/// @throws std::runtime_error saying what is wrong with `position`; it is finite.
Eigen::Vector3d readPosition(const nlohmann::json& attributes);

/// A mesh that could not be read.
struct BadMesh {
  std::size_t member = 0;
  std::string what;
};

/// Attributes of one node that stands for all of `members` (not empty), of the first one's type and
/// in its version's form. Each has a box, an embedding and a position that can be read. What has no
/// meaningful union is the first one's. Meshes that cannot be read are left out, and appended to
/// `bad_meshes`.
nlohmann::json mergeAttributes(const std::vector<const nlohmann::json*>& members,
                               std::vector<BadMesh>& bad_meshes);

}  // namespace tsg::bottleneck
