#pragma once
// The hierarchy of cells over a cube (paper section 3.1, Fig. 6).
// - Level l has 2^l cells a side; level 0 is one cell, the root.
// - Cells are numbered level by level, in Morton order within a level: id = (8^l - 1)/7 + morton,
//   so child k of cell i is 8i + 1 + k and the parent of i is (i - 1)/8, as in Fig. 6.
// - A box covers the cells between the cells of its corners. Positions are clamped to the cube; the map stays
//   monotone, so boxes that overlap share a cell wherever they are.
// - The first levels exist densely, up to kMaxLevel, or less in small scenes. Below, a crowded cell may have
//   a brick: its kBrickLevels next levels, numbered as the levels below a root are; a crowded cell at the bottom of a
//   brick may have one of its own.
// Deviation: the root is a cube, not the scene's box; anisotropic cells cost 3-5 times more tests on thin scenes.

#include "gpu/base/box.hpp"

namespace collided {

constexpr int kMaxLevel = 7;  ///< last dense level of any scene
constexpr int kBrickLevels = 3;
constexpr int kMaxRounds = 4;                                    ///< bricks below each other
constexpr int kDeepest = kMaxLevel + kBrickLevels * kMaxRounds;  ///< levels end here; 2^19 cells a side

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

constexpr uint32_t kBrickCells = level_offset(kBrickLevels + 1) - 1;

/// Cells from lo to hi, both included, of one level.
struct CellRange {
  Coords lo, hi;

  COLLIDED_HD uint64_t size() const { return uint64_t{hi.x - lo.x + 1} * (hi.y - lo.y + 1) * (hi.z - lo.z + 1); }
};

COLLIDED_HD inline Coords shifted(const Coords& c, int s) { return {c.x >> s, c.y >> s, c.z >> s}; }
COLLIDED_HD inline CellRange shifted(const CellRange& r, int s) { return {shifted(r.lo, s), shifted(r.hi, s)}; }

struct LevelGrid {
  Vec3<float> origin;
  float cells_per_length;  ///< at the deepest level
  int top, base;           ///< active dense levels, 0 <= top <= base <= kMaxLevel

  COLLIDED_HD static uint32_t quantise(float x, float origin, float cells_per_length) {
    constexpr float kLast = static_cast<float>((1u << kDeepest) - 1u);
    const float q = (x - origin) * cells_per_length;
    if (!(q > 0)) return 0;
    return static_cast<uint32_t>(q < kLast ? q : kLast);
  }
  /// Cell of the deepest level; the cell of level l is this one shifted by kDeepest - l.
  COLLIDED_HD Coords deepest_cell(const Vec3<float>& p) const {
    return {quantise(p.x, origin.x, cells_per_length), quantise(p.y, origin.y, cells_per_length),
            quantise(p.z, origin.z, cells_per_length)};
  }
  COLLIDED_HD CellRange deepest_range(const Box<float>& box) const {
    return {deepest_cell(box.lo), deepest_cell(box.hi)};
  }
  COLLIDED_HD CellRange range(int level, const Box<float>& box) const {
    return shifted(deepest_range(box), kDeepest - level);
  }
};

/// The cube of the hierarchy over the scene's bounds.
COLLIDED_HD inline LevelGrid grid_over(const Box<float>& bounds, int top, int base) {
  const Vec3<float> extent = bounds.hi - bounds.lo;
  const float side = max(extent.x, max(extent.y, extent.z));
  const float cells = static_cast<float>(1u << kDeepest) / side;
  constexpr float kMax = 0x1.fffffep127f;
  return {bounds.lo, cells < kMax ? cells : side > 0 ? kMax : 0.0f, top, base};
}

/// A leaf of the octree grid: its place and the triangles registered in it.
struct Leaf {
  Coords cell;
  int level;
  uint32_t count;
  uint64_t offset;  ///< of its first registration
};

/// Names of the sums over all leaves.
struct LeafSum {
  enum : uint32_t {
    kCells,  ///< with triangles
    kLeaves,
    kRegistrations,
    kItems,
    kTests,
    kCrowdedTests,  ///< of crowded leaves that might be refined
    kCount
  };
};

/// What the leaves need, added up by all groups.
struct LeafTotals {
  uint64_t sums[LeafSum::kCount];               ///< by LeafSum; an array, so that a thread can take each
  uint64_t level_registrations[kMaxLevel + 2];  ///< of each dense level, then of all bricks

  COLLIDED_HD uint64_t& operator[](uint32_t name) { return sums[name]; }
  COLLIDED_HD uint64_t operator[](uint32_t name) const { return sums[name]; }
};

}  // namespace collided
