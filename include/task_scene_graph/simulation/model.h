// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "task_scene_graph/simulation/solid.h"

namespace tsg::simulation {

/// Axis-aligned rectangle on a horizontal plane, metres.
using Rect = Eigen::AlignedBox2d;

inline Rect makeRect(double x0, double y0, double x1, double y1) {
  return Rect(Eigen::Vector2d(x0, y0), Eigen::Vector2d(x1, y1));
}

/// A horizontal surface of a model that smaller things may stand on, in the model's frame.
struct Support {
  Rect area_m;
  double height_m = 0.0;
  double clearance_m = 1.0;  ///< free height above it
};

/// A thing built from solids. Frame: origin on the floor in the middle of the footprint, z up, the
/// front towards -y and the back (that stands against a wall) towards +y.
class Model {
 public:
  /// `phrase`: what a person would call it; `color_name`: its colour in words.
  Model(std::string phrase, std::string color_name)
      : phrase_(std::move(phrase)), color_name_(std::move(color_name)) {}

  /// Adds a box of full size `size_m` around `center_m`. `part`: which part of the thing it is.
  Model& box(const std::string& part, const Eigen::Vector3d& center_m,
             const Eigen::Vector3d& size_m, const Material& material);
  Model& ellipsoid(const std::string& part, const Eigen::Vector3d& center_m,
                   const Eigen::Vector3d& size_m, const Material& material);
  /// Upright cylinder or, with `top_ratio` < 1, a frustum that narrows upwards.
  Model& cylinder(const std::string& part, const Eigen::Vector3d& center_m, double radius_m,
                  double height_m, const Material& material, double top_ratio = 1.0);
  /// Any solid with a rotation of its own.
  Model& solid(const std::string& part, Shape shape, const Pose& T_model_solid,
               const Eigen::Vector3d& size_m, const Material& material, double top_ratio = 1.0);
  Model& support(const Rect& area_m, double height_m, double clearance_m = 1.0);
  /// A segmenter would see the parts of this thing, not only the whole.
  Model& seenInParts();
  /// Keeps `depth_m` in front of the thing free of other furniture.
  Model& needsFront(double depth_m);
  Model& raisedTo(double height_m);  ///< for things on walls and under ceilings

  const std::string& phrase() const { return phrase_; }
  const std::string& colorName() const { return color_name_; }
  const std::vector<Solid>& solids() const { return solids_; }      ///< poses in the model's frame
  const std::vector<std::string>& parts() const { return parts_; }  ///< one per solid
  const std::vector<Support>& supports() const { return supports_; }
  bool isSeenInParts() const { return seen_in_parts_; }
  double frontClearance() const { return front_clearance_m_; }
  Aabb computeBounds() const;  ///< in the model's frame

 private:
  std::string phrase_;
  std::string color_name_;
  std::vector<Solid> solids_;
  std::vector<std::string> parts_;
  std::vector<Support> supports_;
  bool seen_in_parts_ = false;
  double front_clearance_m_ = 0.0;
};

/// A model at a place in the frame of its arrangement.
struct PlacedModel {
  Model model;
  Pose T_group_model = Pose::Identity();
};

/// Things that are placed together (a table and its chairs), in the frame of the first.
using Arrangement = std::vector<PlacedModel>;

/// Turn about z by a whole number of quarter turns, exact, then a shift.
Pose makeQuarterTurn(int quarter_turns, const Eigen::Vector3d& translation_m);

}  // namespace tsg::simulation
