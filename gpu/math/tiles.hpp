#pragma once
// The pairs among the n members of a leaf as tiles: kTile members against kTile members, so that a warp or a vector
// unit has full work. An item is one row of up to kColumnTiles tiles, so that a leaf of thousands is thousands of
// items.

#include "gpu/exec/host_device.hpp"

namespace collided {

constexpr uint32_t kTile = 32;
constexpr uint32_t kColumnTiles = 8;

/// Tile `row` of a leaf against its tiles `column` to column + kColumnTiles - 1; column >= row, and in a tile with
/// itself each member meets those after it.
struct PairItem {
  uint32_t leaf, row, column;
};

COLLIDED_HD inline uint32_t tiles_of(uint32_t members) { return (members + kTile - 1) / kTile; }

/// Number of items of a leaf.
COLLIDED_HD inline uint64_t items_of(uint32_t members) {
  // Rows have R, R - 1, .., 1 tiles: whole groups of kColumnTiles rows need 1, 2, .. items each.
  const uint64_t rows = tiles_of(members), whole = rows / kColumnTiles, rest = rows % kColumnTiles;
  return kColumnTiles * (whole * (whole + 1) / 2) + rest * (whole + 1);
}

/// write(place, item) for all items of a leaf, places from 0 on.
template <class Write>
COLLIDED_HD void for_each_item(uint32_t leaf, uint32_t members, const Write& write) {
  const uint32_t rows = tiles_of(members);
  uint64_t place = 0;
  for (uint32_t row = 0; row < rows; ++row)
    for (uint32_t column = row; column < rows; column += kColumnTiles) write(place++, PairItem{leaf, row, column});
}

}  // namespace collided
