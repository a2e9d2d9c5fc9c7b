// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "task_scene_graph/map/map.h"

namespace tsg::loops {

/// Where one map lies in another.
struct MapAlignment {
  Pose T_a_b = Pose::Identity();
  std::size_t num_tried = 0;     ///< pairs of places, one of each map
  std::size_t num_fitting = 0;   ///< ... whose surfaces lie on each other
  std::size_t num_agreeing = 0;  ///< ... that say the same of the two maps
  double overlap = 0.0;          ///< of their surfaces, mean
  std::size_t num_things = 0;    ///< primitives with an embedding around them, in b
  std::size_t num_there = 0;     ///< ... that a has too, where it should
};

/// Finds out where map `b` lies in map `a`, of which nothing is known but that both are upright (z
/// up, within 5 degrees) and have seen some of the same. Every two metres of both ways there is a
/// scene: the mesh that can face the camera up to 4 m away, and the primitives with their
/// embeddings. Those that look alike are registered as loop closures are; of all that fit, the
/// largest set that says the same of the two maps wins. It is used only if it has three pairs from
/// two places at least, one in five of the things there is in both maps (six pairs from three
/// places where there are no five things with an embedding), and it has more than twice as many as
/// the next best that says something else: what could be two ways is refused, not guessed. The same
/// result from run to run.
/// O(scenes of a * scenes of b * landmarks^3 + registrations).
/// @throws std::runtime_error saying what was found and what was expected, also where a map has no
/// trajectory or no mesh.
MapAlignment alignMaps(const map::Map& a, const map::Map& b);

/// How many said so, and the transform as `X Y Z QX QY QZ QW`.
std::string toText(const MapAlignment& alignment);

}  // namespace tsg::loops
