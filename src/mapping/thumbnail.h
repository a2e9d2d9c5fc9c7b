// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/mapping/frame_buffer.h"

namespace tsg::mapping {

/// The part of the frame around the segment, a tenth of its size wider on each side, shrunk to at
/// most `max_side_px`. RGB, pixels of its own. Empty if a pointer is null, the sizes disagree, the
/// segment has no pixel or `max_side_px` is 0.
ColorImage makeThumbnail(const SegmentedFrame& view, std::uint16_t segment, int max_side_px);

}  // namespace tsg::mapping
