#pragma once
// The search for pairs on CPU cores: a source's items, member against member, each pair that the source reports handed
// to a sink.

#include <bit>

#include "gpu/math/box.hpp"
#include "gpu/math/tiles.hpp"

namespace collided {

/// What one thread counted.
struct PairTally {
  uint64_t pairs = 0, candidates[2] = {0, 0};
};

/// The boxes of up to kTile members, axis by axis, so that a vector unit can test several at once.
struct BoxTile {
  float lo[3][kTile], hi[3][kTile];
  uint32_t id[kTile], token[kTile];

  template <class Source, class Work>
  void load(const Source& source, const Work& work, uint32_t first, uint32_t count) {
    for (uint32_t k = 0; k < count; ++k) {
      id[k] = work.members[first + k];
      const Box<float> box = source.boxes[id[k]];
      token[k] = source.token(work, box);
      lo[0][k] = box.lo.x, lo[1][k] = box.lo.y, lo[2][k] = box.lo.z;
      hi[0][k] = box.hi.x, hi[1][k] = box.hi.y, hi[2][k] = box.hi.z;
    }
  }
  Box<float> box(uint32_t k) const { return {{lo[0][k], lo[1][k], lo[2][k]}, {hi[0][k], hi[1][k], hi[2][k]}}; }

  /// hit[k] = 1 if member k overlaps the box, else 0.
  void test(const Box<float>& b, uint32_t count, uint32_t* hit) const {
    for (uint32_t k = 0; k < count; ++k)
      hit[k] = static_cast<uint32_t>(b.lo.x <= hi[0][k]) & static_cast<uint32_t>(lo[0][k] <= b.hi.x) &
               static_cast<uint32_t>(b.lo.y <= hi[1][k]) & static_cast<uint32_t>(lo[1][k] <= b.hi.y) &
               static_cast<uint32_t>(b.lo.z <= hi[2][k]) & static_cast<uint32_t>(lo[2][k] <= b.hi.z);
  }
};

/// visit(a, b) for the pairs of an item, lower id first.
template <class Source, class Visit>
void visit_item(const Source& source, uint64_t item, const Visit& visit) {
  const auto work = source.work(item);
  const uint32_t rows = smaller(kTile, work.leaf.count - work.row);
  BoxTile row, column;
  row.load(source, work, work.row, rows);
  uint32_t hit[kTile];
  for (uint32_t first = work.first_column; first < work.end_column; first += kTile) {
    const uint32_t columns = smaller(kTile, work.end_column - first);
    column.load(source, work, first, columns);
    for (uint32_t r = 0; r < rows; ++r) {
      const Box<float> box = row.box(r);
      column.test(box, columns, hit);
      for (uint32_t k = first == work.row ? r + 1 : 0; k < columns; ++k) {
        if (hit[k] == 0) continue;
        const uint32_t a = row.id[r], b = column.id[k];
        if (Source::is_token(row.token[r], column.token[k]) && source.filter(a, b)) visit(smaller(a, b), larger(a, b));
      }
    }
  }
}

/// Hands a pair to the sink: itself, or the candidates of two kinds that it has.
template <class Sink>
void take_pair(const Sink& sink, uint32_t a, uint32_t b, PairTally& tally) {
  ++tally.pairs;
  if constexpr (Sink::kTakesPairs) {
    sink.take(a, b);
  } else {
    for (uint32_t tests = sink.tests_of(a, b); tests != 0; tests &= tests - 1) {
      const int test = std::countr_zero(tests);
      const bool second = test >= Sink::kFirstOfSecondKind;
      if (!(second ? sink.is_second(a, b, test) : sink.is_first(a, b, test))) continue;
      ++tally.candidates[second ? 1 : 0];
      second ? sink.take_second(a, b, test) : sink.take_first(a, b, test);
    }
  }
}

}  // namespace collided
