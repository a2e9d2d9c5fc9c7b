// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "task_scene_graph/trajectory/deformation.h"
#include "task_scene_graph/trajectory/outside_correction.h"

namespace tsg::nodelets {

/// What every stage that holds a part of the map applies to it, in the order of its frames: those
/// given before it lie where they were, those after it where they are. A value; it is under way as
/// long as somebody holds it.
struct MapCorrection {
  trajectory::OutsideCorrection what;
  trajectory::DeformationConfig how;

  /// How what was seen at a stamp moves. O(log keyframes).
  Pose motionAt(Stamp stamp) const { return what.correction.at(what.before.anchorsAt(stamp)); }
  trajectory::Deformation makeDeformation() const { return {what.before, what.correction, how}; }
};

using MapCorrectionPtr = std::shared_ptr<const MapCorrection>;

}  // namespace tsg::nodelets
