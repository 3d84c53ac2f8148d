#pragma once
// The hierarchy of cells over a cube (paper section 3.1, Fig. 6).
// - Level l has 2^l cells a side; level 0 is one cell, the root.
// - Cells are numbered level by level, in Morton order within a level: id = (8^l - 1)/7 + morton,
//   so child k of cell i is 8i + 1 + k and the parent of i is (i - 1)/8, as in Fig. 6.
// - A box covers the cells between the cells of its corners. Positions are clamped to the cube; the map stays
//   monotone, so boxes that overlap share a cell wherever they are.
// Deviation: the root is a cube, not the scene's box; anisotropic cells cost 3-5 times more tests on thin scenes.

#include "gpu/math/box.hpp"

namespace collided {

constexpr int kMaxLevel = 7;

COLLIDED_HD constexpr uint32_t level_offset(int level) {
  return static_cast<uint32_t>(((uint64_t{1} << (3 * level)) - 1) / 7);
}

COLLIDED_HD inline uint32_t spread_bits(uint32_t v) {
  v = (v | (v << 16)) & 0x030000FFu;
  v = (v | (v << 8)) & 0x0300F00Fu;
  v = (v | (v << 4)) & 0x030C30C3u;
  return (v | (v << 2)) & 0x09249249u;
}
COLLIDED_HD inline uint32_t gather_bits(uint32_t v) {
  v &= 0x09249249u;
  v = (v | (v >> 2)) & 0x030C30C3u;
  v = (v | (v >> 4)) & 0x0300F00Fu;
  v = (v | (v >> 8)) & 0x030000FFu;
  return (v | (v >> 16)) & 0x000003FFu;
}

struct Coords {
  uint32_t x, y, z;
};

COLLIDED_HD inline uint32_t morton(const Coords& c) {
  return spread_bits(c.x) | (spread_bits(c.y) << 1) | (spread_bits(c.z) << 2);
}
COLLIDED_HD inline Coords morton_coords(uint32_t code) {
  return {gather_bits(code), gather_bits(code >> 1), gather_bits(code >> 2)};
}
COLLIDED_HD inline uint32_t cell_id(int level, const Coords& c) { return level_offset(level) + morton(c); }
COLLIDED_HD inline int level_of(uint32_t id) {
  int level = 0;
  while (id >= level_offset(level + 1)) ++level;
  return level;
}

/// Cells from lo to hi, both included, of one level.
struct CellRange {
  Coords lo, hi;

  COLLIDED_HD uint64_t size() const { return uint64_t{hi.x - lo.x + 1} * (hi.y - lo.y + 1) * (hi.z - lo.z + 1); }
  COLLIDED_HD Coords cell(uint64_t rank) const {
    const uint64_t width = hi.x - lo.x + 1, height = hi.y - lo.y + 1;
    const uint64_t row = rank / width;
    return {lo.x + static_cast<uint32_t>(rank % width), lo.y + static_cast<uint32_t>(row % height),
            lo.z + static_cast<uint32_t>(row / height)};
  }
};

struct LevelGrid {
  Vec3<float> origin;
  float cells_per_length;  ///< at the base level
  int top, base;           ///< active levels, 0 <= top <= base <= kMaxLevel

  COLLIDED_HD uint32_t quantise(float x, float o) const {
    const float last = static_cast<float>((1u << base) - 1u);
    const float q = (x - o) * cells_per_length;
    if (!(q > 0)) return 0;
    return static_cast<uint32_t>(q < last ? q : last);
  }
  COLLIDED_HD Coords base_cell(const Vec3<float>& p) const {
    return {quantise(p.x, origin.x), quantise(p.y, origin.y), quantise(p.z, origin.z)};
  }
  COLLIDED_HD CellRange range(int level, const Box<float>& box) const {
    const int s = base - level;
    const Coords lo = base_cell(box.lo), hi = base_cell(box.hi);
    return {{lo.x >> s, lo.y >> s, lo.z >> s}, {hi.x >> s, hi.y >> s, hi.z >> s}};
  }
  /// Cells of all active levels that the box covers.
  COLLIDED_HD uint64_t covered(const Box<float>& box) const {
    uint64_t n = 0;
    for (int level = top; level <= base; ++level) n += range(level, box).size();
    return n;
  }
  /// The rank-th of those cells.
  COLLIDED_HD uint32_t covered_cell(const Box<float>& box, uint64_t rank) const {
    for (int level = top;; ++level) {
      const CellRange cells = range(level, box);
      if (rank < cells.size() || level == base) return cell_id(level, cells.cell(rank));
      rank -= cells.size();
    }
  }
};

/// A leaf of the octree grid: its place and how many triangles are registered in it.
struct Leaf {
  Coords cell;
  int level;
  uint32_t count;
};

}  // namespace collided
