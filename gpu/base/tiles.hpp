#pragma once
// The pairs among the n members of a leaf as tiles: kTile members against kTile members, so that a warp or a vector
// unit has full work. An item is a tile, so that a leaf of thousands is thousands of items; in leaves beyond that, a
// run of tiles in a row, so that the items of a leaf are not many more than its members.

#include "gpu/base/host_device.hpp"

namespace collided {

constexpr uint32_t kTile = 32;

/// Tile `row` of a leaf against its tiles from `column` on; column >= row, and in a tile with itself each member meets
/// those after it.
struct PairItem {
  uint32_t leaf, row, column;
};

COLLIDED_HD inline uint32_t tiles_of(uint32_t members) { return (members + kTile - 1) / kTile; }

/// Tiles that an item of a leaf has at most.
COLLIDED_HD inline uint32_t tiles_of_item(uint32_t members) {
  constexpr uint32_t kItemsOfRow = 64;
  const uint32_t rows = tiles_of(members);
  return rows < 2 * kItemsOfRow ? 1 : rows / kItemsOfRow;
}

/// Number of items of the last `rows` rows of a leaf, which have rows, rows - 1, .., 1 tiles.
COLLIDED_HD inline uint64_t items_of_last(uint32_t rows, uint32_t tiles_of_item) {
  if (tiles_of_item == 1) return uint64_t{rows} * (rows + 1) / 2;
  const uint64_t whole = rows / tiles_of_item, rest = rows % tiles_of_item;
  return tiles_of_item * (whole * (whole + 1) / 2) + rest * (whole + 1);
}
COLLIDED_HD inline uint64_t items_of(uint32_t members) {
  return items_of_last(tiles_of(members), tiles_of_item(members));
}

/// write(place, item) for the items of one row; the leaf's places start at 0.
template <class Write>
COLLIDED_HD void for_each_item_of_row(uint32_t leaf, uint32_t members, uint32_t row, const Write& write) {
  const uint32_t rows = tiles_of(members), each = tiles_of_item(members);
  const uint64_t first = items_of(members) - items_of_last(rows - row, each);
  for (uint64_t k = 0; row + k * each < rows; ++k)
    write(first + k, PairItem{leaf, row, static_cast<uint32_t>(row + k * each)});
}

}  // namespace collided
