// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "json_text.h"
#include "spark_dsg_format.h"

namespace tsg::scene_graph {

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
  /// By name, what there is for each point (colours, ...), as it stands in the file: "a,b,c".
  std::map<std::string, std::string> vertex_data;
};

/// The mesh of a node, without points if it has none. Coordinates that are null become NaN.
/// @throws std::runtime_error saying what is wrong with it.
NodeMesh readMesh(const JsonText& text, const JsonObject& attributes, const MeshFrame& frame);

/// Appends; data of vertices that not both have goes, and so it does where they hold it in
/// different forms.
void appendMesh(const NodeMesh& mesh, NodeMesh& sum);

/// The text of `mesh` for a nested mesh; what else the holder has, its header for one, stays.
std::string writeNestedMesh(const NodeMesh& mesh, const MeshFrame& frame, const JsonText& text,
                            const JsonObject& holder);
/// The attributes that hold a flat mesh.
FieldTexts writeFlatMesh(const NodeMesh& mesh, const MeshFrame& frame);

}  // namespace tsg::scene_graph
