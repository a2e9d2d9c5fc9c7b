// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tsg::bottleneck {

/// How a node's mesh lies in the world: p_world = rotation * p_mesh + origin_m.
struct MeshFrame {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
};

/// How a node's attributes hold its mesh.
enum class MeshForm {
  kNested,  ///< `mesh`: {points: [[x, y, z], ...], faces: [[a, b, c], ...], colors: [{...}, ...]}
  kFlat,    ///< `vertices`: [x, y, z, x, ...], `faces`: [a, b, c, a, ...], `colors`: [r, g, b, a,
            ///< ...]
};

/// A node's mesh in the world frame.
struct NodeMesh {
  MeshForm form = MeshForm::kNested;
  std::vector<Eigen::Vector3d> points_m;
  std::vector<std::array<std::size_t, 3>> faces;
  std::map<std::string, nlohmann::json>
      vertex_data;  ///< by name, one entry per point: colours, ...
};

/// The mesh of a node, without points if it has none. Coordinates that are null become NaN.
/// @throws std::runtime_error saying what is wrong with it.
NodeMesh readMesh(const nlohmann::json& attributes, const MeshFrame& frame);

/// Appends; data of vertices that not both have goes, and so it does where they hold it in
/// different forms.
void appendMesh(const NodeMesh& mesh, NodeMesh& sum);

/// Puts a mesh in the place of the one that the attributes hold, in its form.
void writeMesh(const NodeMesh& mesh, const MeshFrame& frame, nlohmann::json& attributes);

}  // namespace tsg::bottleneck
