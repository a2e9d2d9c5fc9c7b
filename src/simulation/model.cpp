// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/model.h"

namespace tsg::simulation {

Model& Model::solid(const std::string& part, Shape shape, const Pose& T_model_solid,
                    const Eigen::Vector3d& size_m, const Material& material, double top_ratio) {
  Solid added;
  added.shape = shape;
  added.T_world_solid = T_model_solid;
  added.half_size_m = 0.5 * size_m;
  added.top_ratio = top_ratio;
  added.material = material;
  solids_.push_back(added);
  parts_.push_back(part);
  return *this;
}

Model& Model::box(const std::string& part, const Eigen::Vector3d& center_m,
                  const Eigen::Vector3d& size_m, const Material& material) {
  return solid(part, Shape::kBox, Pose(Eigen::Translation3d(center_m)), size_m, material);
}

Model& Model::ellipsoid(const std::string& part, const Eigen::Vector3d& center_m,
                        const Eigen::Vector3d& size_m, const Material& material) {
  return solid(part, Shape::kEllipsoid, Pose(Eigen::Translation3d(center_m)), size_m, material);
}

Model& Model::cylinder(const std::string& part, const Eigen::Vector3d& center_m, double radius_m,
                       double height_m, const Material& material, double top_ratio) {
  const Eigen::Vector3d size_m(2.0 * radius_m, 2.0 * radius_m, height_m);
  return solid(part, Shape::kFrustum, Pose(Eigen::Translation3d(center_m)), size_m, material,
               top_ratio);
}

Model& Model::support(const Rect& area_m, double height_m, double clearance_m) {
  supports_.push_back({area_m, height_m, clearance_m});
  return *this;
}

Model& Model::seenInParts() {
  seen_in_parts_ = true;
  return *this;
}

Model& Model::needsFront(double depth_m) {
  front_clearance_m_ = depth_m;
  return *this;
}

Model& Model::raisedTo(double height_m) {
  for (Solid& solid : solids_) solid.T_world_solid.translation().z() += height_m;
  for (Support& support : supports_) support.height_m += height_m;
  return *this;
}

Aabb Model::computeBounds() const {
  Aabb box;
  for (const Solid& solid : solids_) box.extend(simulation::computeBounds(solid));
  return box;
}

Pose makeQuarterTurn(int quarter_turns, const Eigen::Vector3d& translation_m) {
  static constexpr double kCos[4] = {1.0, 0.0, -1.0, 0.0};
  static constexpr double kSin[4] = {0.0, 1.0, 0.0, -1.0};
  const int turn = ((quarter_turns % 4) + 4) % 4;
  Pose T = Pose::Identity();
  T.linear() << kCos[turn], -kSin[turn], 0.0, kSin[turn], kCos[turn], 0.0, 0.0, 0.0, 1.0;
  T.translation() = translation_m;
  return T;
}

}  // namespace tsg::simulation
