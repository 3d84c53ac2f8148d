#pragma once
// A shard of a scene that several backends work on: which pairs of triangles are its own.
// - Space is divided into blocks, cells of one level of a lattice over the scene's bounds. A block has a number, evenly
//   spread by a hash, and a shard the blocks whose numbers lie in its range: blocks of every region, so that shards are
//   about equal wherever the work is.
// - A pair is of the block that holds the larger of its boxes' lower corners, which lies in both boxes: of exactly one.
//   A triangle that touches none of a shard's blocks is in none of its pairs.
// Bounds, and how large triangles are, are numbers that do not depend on any order, so that all shards know the same
// blocks without a word.

#include "gpu/base/lattice.hpp"

namespace collided {

/// Numbers of blocks [begin, end).
struct ShareRange {
  static constexpr uint64_t kAll = uint64_t{1} << 32;

  uint64_t begin = 0, end = kAll;

  bool operator==(const ShareRange&) const = default;
};

/// How many times the blocks' lattice is halved; `mean`: extent of the triangles, in units of the scene's / 2^32. A
/// block is at least 32 triangles wide, so that few triangles are of several; where that makes few blocks, fewer.
COLLIDED_HD inline int block_level(uint64_t mean) {
  constexpr int kMost = 16;
  int level = 0;
  while (level < kMost) {
    const uint64_t triangles = level < 3 ? 1 : level < 4 ? 4 : 32;
    if (ShareRange::kAll >> (level + 1) < triangles * mean) break;
    ++level;
  }
  return level;
}

/// As a backend has it.
struct Share {
  ShareRange range;
  LevelGrid grid;  ///< of the step
  int level;       ///< of its blocks

  COLLIDED_HD bool has(const Coords& block) const {
    const uint64_t number = number_of(block);
    return range.begin <= number && number < range.end;
  }
  COLLIDED_HD bool has(const Vec3<float>& point) const { return has(block_of(point)); }

  /// Whether cells of that level are each within one block, as those of the blocks' own lattice are.
  COLLIDED_HD bool holds_cells(const LevelGrid& of_cells, int cell_level) const {
    const float lattice = grid.cells_per_length;
    return cell_level >= level && lattice > 0 && of_cells.cells_per_length == lattice;
  }
  /// Of such a cell: whether pairs whose larger lower corner it holds are the shard's own.
  COLLIDED_HD bool has_cell(const Coords& cell, int cell_level) const { return has(shifted(cell, cell_level - level)); }
  /// Whether a pair may be its own that a triangle with this box is in.
  COLLIDED_HD bool touches(const Box<float>& box) const {
    constexpr uint64_t kMost = 64;  // triangles of more blocks may be anybody's
    const CellRange blocks{block_of(box.lo), block_of(box.hi)};
    if (blocks.size() > kMost) return true;
    for (uint32_t z = blocks.lo.z; z <= blocks.hi.z; ++z)
      for (uint32_t y = blocks.lo.y; y <= blocks.hi.y; ++y)
        for (uint32_t x = blocks.lo.x; x <= blocks.hi.x; ++x)
          if (has(Coords{x, y, z})) return true;
    return false;
  }

 private:
  COLLIDED_HD Coords block_of(const Vec3<float>& point) const {
    return shifted(grid.deepest_cell(point), kDeepest - level);
  }
  /// Below ShareRange::kAll (Stafford 2011, variant 13 of MurmurHash3's finalizer).
  COLLIDED_HD static uint64_t number_of(const Coords& block) {
    uint64_t h = block.x | uint64_t{block.y} << 20 | uint64_t{block.z} << 40;
    h = (h + 0x9E3779B97F4A7C15u) ^ (h + 0x9E3779B97F4A7C15u) >> 30;
    h *= 0xBF58476D1CE4E5B9u;
    h = (h ^ h >> 27) * 0x94D049BB133111EBu;
    return (h ^ h >> 31) >> 32;
  }
};

/// Which pairs are a shard's own. Of a scene that is one: all.
struct SharedPairs {
  const Share* share = nullptr;
  const Box<float>* boxes = nullptr;  ///< of the triangles

  COLLIDED_HD bool is_needed() const { return share != nullptr; }
  /// Whether all pairs of a leaf are of one shard.
  COLLIDED_HD bool has_leaves_of_one_part(const LevelGrid& grid, int level) const {
    return !is_needed() || share->holds_cells(grid, level);
  }
  /// Of two triangles whose boxes overlap.
  COLLIDED_HD bool has(uint32_t a, uint32_t b) const {
    if (!is_needed()) return true;
    const Vec3<float> p = boxes[a].lo, q = boxes[b].lo;
    return share->has(Vec3<float>{max(p.x, q.x), max(p.y, q.y), max(p.z, q.z)});
  }
};

}  // namespace collided
