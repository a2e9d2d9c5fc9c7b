// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "task_scene_graph/core/camera.h"
#include "task_scene_graph/simulation/apartment.h"
#include "task_scene_graph/simulation/random.h"

namespace tsg::simulation {

/// Two sets of surfaces without a common one, so that networks can be tested on what they were not
/// trained on.
enum class SurfaceSet {
  kTraining,  ///< floors: planks, tiles, carpet; pale walls
  kHeldOut    ///< floors: stripes, wood in one piece; walls of stronger colour
};

/// Gives the apartment other surfaces: floors and walls drawn from the set, and for each instance a
/// shift of hue, saturation and brightness that leaves its colour's name true. Everything follows
/// from the seed.
void varySurfaces(Apartment& apartment, SurfaceSet set, std::uint64_t seed);

/// Optical frames (world z up, no roll) of a person's or a robot's camera at random places that can
/// be walked to, 0.9 m to 1.7 m high, each with at least two instances in view. May be fewer than
/// `count` in an apartment with little to see. Everything follows from `random`.
std::vector<Pose> pickRandomViews(const Apartment& apartment, int count, Random& random);

/// A camera with the field of view of a 640 px wide image with fx = fy = 525 px.
CameraModel makeDefaultCamera(int width_px, int height_px);

}  // namespace tsg::simulation
