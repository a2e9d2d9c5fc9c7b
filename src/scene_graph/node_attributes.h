// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "json_text.h"
#include "node_box.h"
#include "spark_dsg_format.h"
#include "task_scene_graph/core/embedding.h"

namespace tsg::scene_graph {

/// Mean of the columns of `semantic_feature`; finite and not zero.
/// @throws std::runtime_error saying what is wrong with it.
Embedding readEmbedding(const JsonText& json, const JsonObject& attributes);
/// @throws std::runtime_error saying what is wrong with `position`; it is finite.
Eigen::Vector3d readPosition(const nlohmann::json& attributes);

/// Some fields of an object, as far as it has them.
nlohmann::json readFields(const JsonText& text, const JsonObject& object,
                          const std::vector<std::string>& names);

/// A mesh that could not be read.
struct BadMesh {
  std::size_t member = 0;
  std::string what;
};

/// What one node has that stands for all of `members` (not empty) besides its embedding, where that
/// is not what the first one has: in its form, what has no meaningful union from there. The
/// members' boxes can be read. Meshes that cannot be read are left out, and appended to
/// `bad_meshes`.
FieldTexts mergeAttributes(const JsonText& text, const std::vector<JsonObject>& members,
                           const Aabb& hull, const Eigen::Vector3d& position_m,
                           std::vector<BadMesh>& bad_meshes);

}  // namespace tsg::scene_graph
