// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "ply_file.h"
#include "task_scene_graph/evaluation/class_scores.h"

namespace tsg::evaluation {

LabelledPoints loadLabelledPoints(const std::string& path, const std::string& property) {
  PlyFile file(path);
  const PlyElement& vertices = file.vertices();
  const std::size_t x = file.findProperty(vertices, "x");
  const std::size_t y = file.findProperty(vertices, "y");
  const std::size_t z = file.findProperty(vertices, "z");
  const std::size_t label = file.findProperty(vertices, property);
  for (const std::size_t column : {x, y, z, label}) {
    if (!vertices.properties[column].count_type.empty()) {
      file.fail("'" + vertices.properties[column].name + "' is a list, expected a number");
    }
  }
  LabelledPoints points;
  PlyRow row;
  for (std::size_t i = 0; i < vertices.count; ++i) {
    file.readRow(vertices, i, row);
    const Eigen::Vector3d p(row[x][0], row[y][0], row[z][0]);
    const double value = row[label][0];
    if (!p.allFinite() || !(std::abs(value) < 1e6 && value >= kNoClass)) {
      file.fail("vertex " + std::to_string(i) +
                " has a place or a label that is no number, or a label below -1");
    }
    points.points_m.push_back(p);
    points.classes.push_back(static_cast<int>(value));
  }
  return points;
}

}  // namespace tsg::evaluation
