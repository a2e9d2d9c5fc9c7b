// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

namespace tsg::scene_graph {

/// @throws std::runtime_error always.
[[noreturn]] void fail(const std::string& what);
/// "has 'name' = value, expected ...", a long value cut off. @throws std::runtime_error always.
[[noreturn]] void failOn(const char* name, const nlohmann::json& value, const char* expected);

/// @throws std::runtime_error "has no 'name'".
const nlohmann::json& getField(const nlohmann::json& object, const char* name);
/// @throws std::runtime_error if it is absent or not 3 numbers.
Eigen::Vector3d readVector(const nlohmann::json& object, const char* name);

nlohmann::json toJson(const Eigen::Vector3d& v);

}  // namespace tsg::scene_graph
