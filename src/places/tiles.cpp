// SPDX-License-Identifier: BSD-3-Clause
#include "tiles.h"

#include <algorithm>
#include <map>

namespace tsg::places {
namespace {

constexpr int kMaxBoxTiles = 20;

TileBox makeBox(std::vector<TileIndex> tiles) {
  TileBox box{tiles.front(), tiles.front(), {}};
  for (const TileIndex& tile : tiles) {
    box.min = {std::min(box.min.first, tile.first), std::min(box.min.second, tile.second)};
    box.max = {std::max(box.max.first, tile.first), std::max(box.max.second, tile.second)};
  }
  box.tiles = std::move(tiles);
  return box;
}

bool isSmall(const TileBox& box) {
  return box.max.first - box.min.first < kMaxBoxTiles &&
         box.max.second - box.min.second < kMaxBoxTiles;
}

void divide(const TileBox& box, std::vector<TileBox>& boxes) {
  std::map<TileIndex, std::vector<TileIndex>> parts;
  for (const TileIndex& tile : box.tiles) {
    parts[{(tile.first - box.min.first) / kMaxBoxTiles,
           (tile.second - box.min.second) / kMaxBoxTiles}]
        .push_back(tile);
  }
  for (auto& [part, tiles] : parts) boxes.push_back(makeBox(std::move(tiles)));
}

}  // namespace

/// Along one axis, then along the other.
TileSet widen(const TileSet& tiles, int rings) {
  std::vector<TileIndex> wide(tiles.begin(), tiles.end());
  for (const TileIndex& axis : {TileIndex{0, 1}, TileIndex{1, 0}}) {
    std::vector<TileIndex> next;
    next.reserve(wide.size() * static_cast<std::size_t>(2 * rings + 1));
    for (const auto& [x, y] : wide) {
      for (int step = -rings; step <= rings; ++step) {
        next.emplace_back(x + step * axis.first, y + step * axis.second);
      }
    }
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    wide = std::move(next);
  }
  return {wide.begin(), wide.end()};
}

std::vector<TileBox> coverByBoxes(const TileSet& tiles) {
  std::vector<TileBox> boxes;
  for (auto& island : splitIntoIslands({tiles.begin(), tiles.end()}, kTileSide)) {
    TileBox box = makeBox(std::move(island));
    if (isSmall(box)) {
      boxes.push_back(std::move(box));
    } else {
      divide(box, boxes);
    }
  }
  return boxes;
}

GridExtent computeExtent(const TileBox& box, int margin) {
  const GridIndex min(box.min.first * kTileSide - margin, box.min.second * kTileSide - margin, 0);
  const GridIndex size((box.max.first - box.min.first + 1) * kTileSide + 2 * margin,
                       (box.max.second - box.min.second + 1) * kTileSide + 2 * margin, 1);
  return {min, size};
}

}  // namespace tsg::places
