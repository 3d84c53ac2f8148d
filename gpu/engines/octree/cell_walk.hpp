#pragma once
// The cells of several levels that a box covers: any of them by its place, or all in turn.
// The coarsest level comes first: its few cells are the same for many boxes, and threads that begin with them together
// share their atomics.

#include "gpu/base/lattice.hpp"

namespace collided {

/// k / d; both below 2^21. On a GPU integers have no division of their own, and floats a fast one that is close enough:
/// (k + 1/2) / d is at least 1/(2d) away from any integer, and the error of 2 units in the last place less than that.
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

/// A range of cells of the level `base` and the cells above it up to the level `top`, in few words.
class LevelsOfCells {
 public:
  LevelsOfCells() = default;
  COLLIDED_HD LevelsOfCells(const CellRange& range, int top, int base)
      : lo_(packed(range.lo) | static_cast<uint32_t>(base) << kLevelAt), hi_(packed(range.hi)) {
    hi_ |= static_cast<uint32_t>(top) << kLevelAt;
  }

  COLLIDED_HD int top() const { return static_cast<int>(hi_ >> kLevelAt); }
  COLLIDED_HD int base() const { return static_cast<int>(lo_ >> kLevelAt); }
  COLLIDED_HD CellRange range(int level) const {
    return shifted(CellRange{unpacked(lo_), unpacked(hi_)}, base() - level);
  }
  COLLIDED_HD uint32_t cells_at(int level) const {
    const CellRange r = range(level);
    return (r.hi.x - r.lo.x + 1) * (r.hi.y - r.lo.y + 1) * (r.hi.z - r.lo.z + 1);
  }
  COLLIDED_HD uint32_t cells() const {
    uint32_t sum = 0;
#ifdef __CUDA_ARCH__
#pragma unroll 1
#endif
    for (int level = top(); level <= base(); ++level) sum += cells_at(level);
    return sum;
  }
  /// Number of the k-th cell.
  COLLIDED_HD uint32_t cell(uint32_t k) const {
    int level = top();
#ifdef __CUDA_ARCH__
#pragma unroll 1  // short kernels wait for the memory that their instructions come from
#endif
    for (uint32_t n = cells_at(level); k >= n; n = cells_at(++level)) k -= n;
    const CellRange r = range(level);
    return cell_id(level, nth_cell(k, r.lo, r.hi.x - r.lo.x + 1, r.hi.y - r.lo.y + 1));
  }

 private:
  static constexpr uint32_t kBits = kMaxLevel, kMask = (1u << kBits) - 1u, kLevelAt = 3 * kBits;
  static_assert(kBrickLevels <= kMaxLevel);
  uint32_t lo_ = 0, hi_ = 0;

  COLLIDED_HD static uint32_t packed(const Coords& c) { return c.x | c.y << kBits | c.z << 2 * kBits; }
  COLLIDED_HD static Coords unpacked(uint32_t c) { return {c & kMask, c >> kBits & kMask, c >> 2 * kBits & kMask}; }
};

/// The same cells in the same order, one by one: a step is a few operations on Morton codes, without branches, so that
/// the lanes of a warp can each walk their own.
class CellWalk {
 public:
  /// `first` is added to every number.
  COLLIDED_HD CellWalk(const LevelsOfCells& levels, uint32_t first)
      : first_(first), up_(3 * (levels.base() - levels.top())), level_offset_(level_offset(levels.top())) {
    const CellRange range = levels.range(levels.base());
    base_lo_ = code(range.lo), base_hi_ = code(range.hi);
    start_level();
  }
  /// From the k-th cell on, which there must be.
  COLLIDED_HD CellWalk(const LevelsOfCells& levels, uint32_t first, uint32_t k) : CellWalk(levels, first) {
    for (uint32_t n = levels.cells_at(level_of(levels)); k >= n; n = levels.cells_at(level_of(levels))) {
      k -= n;
      next_level();
    }
    const CellRange r = levels.range(level_of(levels));
    cell_ = code(nth_cell(k, r.lo, r.hi.x - r.lo.x + 1, r.hi.y - r.lo.y + 1));
  }

  /// May be called past the end, for any number.
  COLLIDED_HD uint32_t next() {
    const uint32_t cell = first_ + level_offset_ + cell_;
    step();
    return cell;
  }

 private:
  static constexpr uint32_t kX = 0x09249249u, kY = kX << 1, kZ = kX << 2;
  uint32_t first_;
  int up_;  ///< bits of a Morton code from the base to this level
  uint32_t level_offset_;
  uint32_t base_lo_ = 0, base_hi_ = 0;
  uint32_t lo_ = 0, hi_ = 0, cell_ = 0;  ///< Morton codes of this level

  /// morton(), where coordinates have at most 8 bits.
  COLLIDED_HD static uint32_t code(const Coords& c) { return spread(c.x) | spread(c.y) << 1 | spread(c.z) << 2; }
  COLLIDED_HD static uint32_t spread(uint32_t v) {
    static_assert(kMaxLevel <= 8);
    v = (v | v << 8) & 0x0300F00Fu;
    v = (v | v << 4) & 0x030C30C3u;
    return (v | v << 2) & kX;
  }
  COLLIDED_HD void start_level() { lo_ = cell_ = base_lo_ >> up_, hi_ = base_hi_ >> up_; }
  /// Goes on along the first axis that is not at its end; those before it start again.
  COLLIDED_HD void step() {
    const uint32_t left = cell_ ^ hi_;
    const bool in_row = (left & kX) != 0, in_layer = (left & kY) != 0;
    const uint32_t axis = in_row ? kX : in_layer ? kY : kZ;
    const uint32_t again = in_row ? 0 : in_layer ? kX : kX | kY;
    cell_ = (cell_ & ~(axis | again)) | (((cell_ & axis) - axis) & axis) | (lo_ & again);
    if (left == 0) next_level();
  }
  COLLIDED_HD void next_level() {
    up_ = up_ > 3 ? up_ - 3 : 0;
    level_offset_ = 8 * level_offset_ + 1;
    start_level();
  }
  COLLIDED_HD int level_of(const LevelsOfCells& levels) const { return levels.base() - up_ / 3; }
};

}  // namespace collided
