// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "object_volume.h"

namespace tsg::mapping {

/// Takes stray surface out of an object's label: what lies apart from its largest part and has less
/// than `min_part_share` of that part's points. Masks spill over silhouettes, so a thing comes with
/// a strip of the wall behind it, which no view alone can tell from the thing.
///
/// Points of all views fall into cells of twice resolution_fraction of the extent (3 cm and 5
/// pixels at least); cells that touch are one part. Since what is taken out may have been most of
/// the extent, this is done again at the smaller one.
/// @param extent  of the points of all views
/// @return the extent of what is left, as computeExtent(); views with too little left are removed
/// O(pixels of the labels + cells).
Aabb keepMainPart(const ObjectConfig& config, const Aabb& extent, std::vector<ObjectView>& views);

}  // namespace tsg::mapping
