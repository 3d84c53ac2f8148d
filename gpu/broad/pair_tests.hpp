#pragma once
// Section 3.3: box tests between the triangles of a leaf, spread evenly over threads.
// The n triangles of a leaf play a round-robin tournament: row i meets rows i+1 .. i+n/2 (mod n), so every row has
// the same work and each unordered pair comes up once. A unit is kRoundsPerUnit rounds of one row, so a leaf of
// thousands becomes thousands of units of many threads.
// Token rule: of the leaves that both triangles are in, only the one that holds the larger of the lower corners
// reports the pair; over any partition into leaves that is exactly one (reference point method).

#include "gpu/broad/pair_filter.hpp"
#include "gpu/exec/atomic.hpp"
#include "gpu/math/lattice.hpp"

namespace collided {

constexpr uint32_t kRoundsPerUnit = 32;

struct CountPairUnits {
  Span<const Leaf> leaves;
  Span<uint64_t> units;  ///< one more than leaves

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint64_t n = i < leaves.size() ? leaves[i].count : 0;
    units[i] = n * ((n / 2 + kRoundsPerUnit - 1) / kRoundsPerUnit);
  }
};

/// Triangle pair, lower id first.
struct TrianglePair {
  uint32_t a, b;
};

struct TestPairsOfLeaf {
  LevelGrid grid;
  PairFilter filter;
  Span<const Box<float>> boxes;
  Span<const Leaf> leaves;
  Span<const uint64_t> offsets;
  Span<const uint32_t> registered;
  AppendList<TrianglePair> pairs;

  COLLIDED_HD void operator()(uint64_t leaf_index, uint64_t rank) const {
    const Leaf leaf = leaves[leaf_index];
    const uint32_t n = leaf.count;
    const uint32_t* members = registered.data + offsets[leaf_index];
    const uint32_t row = static_cast<uint32_t>(rank % n);
    const uint32_t first = 1 + kRoundsPerUnit * static_cast<uint32_t>(rank / n);
    const uint32_t last = smaller(first + kRoundsPerUnit - 1, n / 2);
    const uint32_t a = members[row];
    const Box<float> box = boxes[a];
    for (uint32_t round = first; round <= last; ++round) {
      if (2 * round == n && row >= round) break;  // the half-way round meets each pair twice
      const uint32_t other = row + round < n ? row + round : row + round - n;
      test(leaf, box, a, members[other]);
    }
  }

 private:
  COLLIDED_HD void test(const Leaf& leaf, const Box<float>& box_a, uint32_t a, uint32_t b) const {
    const Box<float> box_b = boxes[b];
    if (!overlap(box_a, box_b) || !holds_token(leaf, box_a, box_b) || !filter(a, b)) return;
    pairs.push({smaller(a, b), larger(a, b)});
  }
  COLLIDED_HD bool holds_token(const Leaf& leaf, const Box<float>& a, const Box<float>& b) const {
    const Coords token = grid.base_cell({larger(a.lo.x, b.lo.x), larger(a.lo.y, b.lo.y), larger(a.lo.z, b.lo.z)});
    const int s = grid.base - leaf.level;
    return (token.x >> s) == leaf.cell.x && (token.y >> s) == leaf.cell.y && (token.z >> s) == leaf.cell.z;
  }
};

}  // namespace collided
