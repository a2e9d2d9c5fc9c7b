// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>

namespace tsg {

/// An integer id that cannot be mixed up with an id of another kind. Ids count from 1; 0 is "none".
template <typename Tag>
struct Id {
  std::uint64_t value = 0;

  bool isValid() const { return value != 0; }
  friend bool operator==(Id a, Id b) { return a.value == b.value; }
  friend bool operator!=(Id a, Id b) { return a.value != b.value; }
  friend bool operator<(Id a, Id b) { return a.value < b.value; }
};

using TrackId = Id<struct TrackTag>;
using PrimitiveId = Id<struct PrimitiveTag>;
using ObjectId = Id<struct ObjectTag>;
using PlaceId = Id<struct PlaceTag>;
using RegionId = Id<struct RegionTag>;

}  // namespace tsg

template <typename Tag>
struct std::hash<tsg::Id<Tag>> {
  std::size_t operator()(tsg::Id<Tag> id) const noexcept {
    return std::hash<std::uint64_t>()(id.value);
  }
};
