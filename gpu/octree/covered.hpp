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

/// The dense cells of one level that a triangle covers, in a form that threads can hand to each other.
struct CoveredCells {
  static constexpr uint32_t kMostParts = 48;
  uint32_t parts = 0;  ///< cells
  uint32_t triangle = 0;

  CoveredCells() = default;
  COLLIDED_HD CoveredCells(uint32_t id, int level, const CellRange& range)
      : parts(static_cast<uint32_t>(range.size())),
        triangle(id),
        lo_(range.lo.x | range.lo.y << kBits | range.lo.z << 2 * kBits | static_cast<uint32_t>(level) << 3 * kBits),
        size_((range.hi.x - range.lo.x + 1) | (range.hi.y - range.lo.y + 1) << 16) {}

  /// Index of the k-th cell.
  COLLIDED_HD uint32_t cell(uint32_t k) const {
    constexpr uint32_t kMask = (1u << kBits) - 1u;
    const Coords lo{lo_ & kMask, lo_ >> kBits & kMask, lo_ >> 2 * kBits & kMask};
    return cell_id(static_cast<int>(lo_ >> 3 * kBits), nth_cell(k, lo, size_ & 0xFFFFu, size_ >> 16));
  }

 private:
  static constexpr uint32_t kBits = 9;
  static_assert(kMaxLevel <= 9);
  uint32_t lo_ = 0, size_ = 0;
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
