#pragma once
// The cells that a triangle covers, in a form that threads can hand to each other: how many, and which is the k-th.

#include "gpu/octree/tree.hpp"

namespace collided {

/// k / d; both below 2^16. On a GPU integers have no division of their own, and floats a fast one that is close enough.
COLLIDED_HD inline uint32_t small_quotient(uint32_t k, uint32_t d) {
#ifdef __CUDA_ARCH__
  return static_cast<uint32_t>(__fdividef(static_cast<float>(k) + 0.5f, static_cast<float>(d)));
#else
  return k / d;
#endif
}

/// The k-th cell, of a box of cells `width` and `height` wide.
COLLIDED_HD inline Coords nth_cell(uint32_t k, const Coords& lo, uint32_t width, uint32_t height) {
  const uint32_t row = small_quotient(k, width), layer = small_quotient(row, height);
  return {lo.x + (k - row * width), lo.y + (row - layer * height), lo.z + layer};
}

/// The cells of all active dense levels that a triangle covers: those of the base level first, then level by level
/// upwards.
struct CoveredCells {
  static constexpr uint32_t kMostBase = 48;  ///< base cells; triangles with more are left to groups of threads
  static constexpr uint32_t kMostParts = 2 * kMostBase + kMaxLevel;
  uint32_t parts = 0;  ///< cells; 0: too many base cells
  uint32_t triangle = 0;

  CoveredCells() = default;
  /// From the level `top` on, down to the base.
  COLLIDED_HD CoveredCells(uint32_t id, const LevelGrid& grid, const CellRange& deepest, int top) : triangle(id) {
    const CellRange range = shifted(deepest, kDeepest - grid.base);
    if (range.size() > kMostBase) return;
    lo_ = packed(range.lo) | static_cast<uint32_t>(grid.base) << 3 * kBits;
    hi_ = packed(range.hi);
    for (int up = 0; up <= grid.base - top; ++up) parts += static_cast<uint32_t>(shifted(range, up).size());
  }

  COLLIDED_HD int base() const { return static_cast<int>(lo_ >> 3 * kBits); }
  /// Index of the k-th cell.
  COLLIDED_HD uint32_t cell(uint32_t k) const {
    CellRange range{unpacked(lo_), unpacked(hi_)};
    int level = base();
    for (;; --level, range = shifted(range, 1)) {
      const uint32_t width = range.hi.x - range.lo.x + 1, height = range.hi.y - range.lo.y + 1;
      const uint32_t size = width * height * (range.hi.z - range.lo.z + 1);
      if (k < size) return cell_id(level, nth_cell(k, range.lo, width, height));
      k -= size;
    }
  }

 private:
  static constexpr uint32_t kBits = kMaxLevel, kMask = (1u << kBits) - 1u;
  uint32_t lo_ = 0, hi_ = 0;  ///< base cells

  COLLIDED_HD static uint32_t packed(const Coords& c) { return c.x | c.y << kBits | c.z << 2 * kBits; }
  COLLIDED_HD static Coords unpacked(uint32_t c) { return {c & kMask, c >> kBits & kMask, c >> 2 * kBits & kMask}; }
};

/// The cells of a brick that a triangle covers: those of its bottom level first, then level by level upwards.
struct CoveredInBrick {
  static constexpr uint32_t kMostParts = kBrickCells;
  uint32_t parts = 0;  ///< cells
  uint32_t triangle = 0, brick = 0;

  CoveredInBrick() = default;
  COLLIDED_HD CoveredInBrick(const Tree& tree, const BrickItem& item, const CellRange& deepest)
      : triangle(item.triangle), brick(item.brick) {
    const Brick root = tree.bricks[brick];
    const CellRange range = shifted(deepest, kDeepest - root.level - kBrickLevels);
    lo_ = packed({offset(range.lo.x, root.cell.x), offset(range.lo.y, root.cell.y), offset(range.lo.z, root.cell.z)});
    hi_ = packed({offset(range.hi.x, root.cell.x), offset(range.hi.y, root.cell.y), offset(range.hi.z, root.cell.z)});
    for (int depth = kBrickLevels; depth > 0; --depth) parts += cells_at(depth);
  }

  COLLIDED_HD uint32_t cells_at(int depth) const { return static_cast<uint32_t>(range_at(depth).size()); }
  /// Index of the k-th cell.
  COLLIDED_HD uint32_t cell(uint32_t k) const {
    int depth = kBrickLevels;
    for (uint32_t n = cells_at(depth); k >= n; n = cells_at(--depth)) k -= n;
    const CellRange r = range_at(depth);
    return brick_cell(brick, level_offset(depth) + morton(nth_cell(k, r.lo, r.hi.x - r.lo.x + 1, r.hi.y - r.lo.y + 1)));
  }

 private:
  static constexpr uint32_t kLast = (1u << kBrickLevels) - 1u;
  uint32_t lo_ = 0, hi_ = 0;

  /// Of a bottom cell from the first one below the root, kept within the brick.
  COLLIDED_HD static uint32_t offset(uint32_t cell, uint32_t root) {
    const uint32_t first = root << kBrickLevels;
    return cell < first ? 0 : smaller(cell - first, kLast);
  }
  COLLIDED_HD static uint32_t packed(const Coords& c) { return c.x | c.y << kBrickLevels | c.z << 2 * kBrickLevels; }
  COLLIDED_HD static Coords unpacked(uint32_t c) {
    return {c & kLast, c >> kBrickLevels & kLast, c >> 2 * kBrickLevels};
  }
  COLLIDED_HD CellRange range_at(int depth) const {
    return shifted(CellRange{unpacked(lo_), unpacked(hi_)}, kBrickLevels - depth);
  }
};

}  // namespace collided
