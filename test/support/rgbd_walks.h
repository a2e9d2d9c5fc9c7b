// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "task_scene_graph/core/frame.h"

namespace tsg::test {

/// Posed frames in the order of their stamps.
using RgbdWalk = std::vector<RgbdFrame>;

/// How the camera moves in makeBoxRoomWalk.
enum class BoxRoomMotion {
  kForward,   ///< towards a wall, 2 cm per frame
  kTurning,   ///< on the spot, 1.1 degrees per frame
  kSideways,  ///< along a wall it looks at, 2 cm per frame, straight at it
  kMixed,     ///< sideways and forward, turning
  kCircle,    ///< round the room's centre, looking outward and ahead
  kStill
};

/// An empty room of 6 x 6 x 2.5 m with plain walls, 160x120 at 10 Hz, exact float depth.
RgbdWalk makeBoxRoomWalk(BoxRoomMotion motion, int num_frames);

/// A stretch of the walk through a generated apartment at 10 Hz, with the depth of an active stereo
/// camera (noise, holes, millimetres).
RgbdWalk makeApartmentWalk(int seed, int width_px, int first_frame, int num_frames);

/// Every `stride`-th frame of a folder in 7-Scenes layout, at `rate_hz`. `width_px` 160 keeps every
/// fourth pixel of 640, 640 all.
RgbdWalk loadWalk(const std::filesystem::path& folder, int num_frames, double rate_hz, int stride,
                  int width_px);

/// Frames first, first + 1, ... of at most `count`.
RgbdWalk cut(const RgbdWalk& walk, std::size_t first, std::size_t count);

}  // namespace tsg::test
