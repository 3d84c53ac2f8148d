#pragma once
// The search for pairs on CPU cores: a source's items, member against member, four at a time.

#include <array>
#include <bit>

#include "gpu/base/mesh_filter.hpp"
#include "gpu/base/tiles.hpp"
#include "gpu/exec/cpu/cpu_loops.hpp"
#include "gpu/search/cpu/lanes.hpp"

namespace collided {

/// The boxes of up to kTile members of a leaf.
struct BoxTile {
  BoxLanes<float> boxes[kTile / 4];
  uint32_t id[kTile];
  uint32_t starts[3];     ///< bit k: member k's box starts in the leaf's cell on this axis
  MeshesTogether meshes;  ///< where the source's filter has rules

  template <class Source, class Work>
  void load(const Source& source, const Work& work, const uint32_t* members, uint32_t count) {
    starts[0] = starts[1] = starts[2] = 0;
    meshes = {};
    for (uint32_t k = 0; k < count; ++k) {
      id[k] = members[k];
      const Box<float> box = source.boxes[id[k]];
      boxes[k / 4].set(k % 4, box);
      const uint32_t axes = source.axes_of_start(work, box);
      for (int axis = 0; axis < 3; ++axis) starts[axis] |= (axes >> axis & 1u) << k;
      if (source.filter.has_rules()) meshes.add(source.filter.meshes_of(id[k]));
    }
    for (uint32_t k = count; k % 4 != 0; ++k) boxes[k / 4].set(k % 4, boxes[k / 4].get(0));  // no matter: cut off
  }

  /// Members that together with member k of another tile start in the leaf's cell on all axes.
  uint32_t starting_with(const BoxTile& other, uint32_t k) const {
    uint32_t members = ~0u;
    for (int axis = 0; axis < 3; ++axis) members &= starts[axis] | (0u - (other.starts[axis] >> k & 1u));
    return members;
  }
  /// Of the first `count` members, those whose boxes meet member k's of another tile.
  uint32_t meeting(const BoxTile& other, uint32_t k, uint32_t count) const {
    const BoxLanes<float> box = other.boxes[k / 4].spread(static_cast<int>(k % 4));
    uint32_t hits = 0;
    for (uint32_t group = 0; 4 * group < count; ++group) hits |= meeting_lanes(box, boxes[group]) << (4 * group);
    return hits & ~0u >> (kTile - count);
  }
};

/// Tiles of the leaf at hand, which several items in a row work on.
class LeafTiles {
 public:
  /// The tile of the rows, members [row, ...) of the work's leaf.
  template <class Source, class Work, class Prefetch>
  const BoxTile& rows(const Source& source, const Work& work, uint32_t count, const Prefetch& prefetch) {
    return tile(row_, source, work, work.row, count, prefetch);
  }
  template <class Source, class Work, class Prefetch>
  const BoxTile& columns(const Source& source, const Work& work, uint32_t first, uint32_t count,
                         const Prefetch& prefetch) {
    return tile(columns_[first / kTile % columns_.size()], source, work, first, count, prefetch);
  }

 private:
  struct Slot {
    const uint32_t* members = nullptr;  ///< that are loaded
    BoxTile tile;
  };
  template <class Source, class Work, class Prefetch>
  static const BoxTile& tile(Slot& slot, const Source& source, const Work& work, uint32_t first, uint32_t count,
                             const Prefetch& prefetch) {
    const uint32_t* members = work.members + first;
    if (slot.members == members) return slot.tile;
    slot.members = members;
    for (uint32_t k = 0; k < count; ++k) prefetch(members[k]);
    slot.tile.load(source, work, members, count);
    return slot.tile;
  }

  Slot row_;
  std::array<Slot, 16> columns_;
};

/// visit(row, column) for the pairs of two tiles, or of one with itself. `is_own`: all are the part's own.
template <class Source, class Visit>
void visit_tile(const Source& source, const BoxTile& row, uint32_t rows, const BoxTile& column, uint32_t columns,
                bool is_own, const Visit& visit) {
  if (source.filter.has_rules() && !source.filter.may_pass(row.meshes, column.meshes)) return;
  const bool with_itself = &row == &column;
  for (uint32_t r = 0; r < rows; ++r) {
    uint32_t wanted = column.starting_with(row, r);
    if (with_itself) wanted &= ~0u << r << 1;  // only those after this one
    if (wanted != 0) wanted &= column.meeting(row, r, columns);
    for (; wanted != 0; wanted &= wanted - 1) {
      const uint32_t a = row.id[r], b = column.id[std::countr_zero(wanted)];
      if (source.filter(a, b, is_own)) visit(a, b);
    }
  }
}

/// visit(row, column) for the pairs of an item, from its tile `part` on, until `tests` have been made; whether that was
/// all. Before that, prefetch(member) for those that may be in some pair.
template <class Source, class Visit, class Prefetch>
bool visit_tiles(const Source& source, uint64_t item, uint64_t& part, uint64_t& tests, LeafTiles& tiles,
                 const Visit& visit, const Prefetch& prefetch) {
  const auto work = source.work(item);
  const uint32_t rows = min(kTile, work.leaf.count - work.row);
  const BoxTile& row = tiles.rows(source, work, rows, prefetch);
  uint32_t first = work.first_column + static_cast<uint32_t>(part) * kTile;
  for (; first < work.end_column && tests > 0; first += kTile, ++part) {
    const uint32_t columns = min(kTile, work.end_column - first);
    const BoxTile& column = first == work.row ? row : tiles.columns(source, work, first, columns, prefetch);
    visit_tile(source, row, rows, column, columns, work.is_own, visit);
    tests -= min(tests, uint64_t{rows} * columns);
  }
  return first >= work.end_column;
}

template <class Source, class Visit>
void visit_item(const Source& source, uint64_t item, LeafTiles& tiles, const Visit& visit) {
  uint64_t part = 0, tests = ~uint64_t{0};
  visit_tiles(source, item, part, tests, tiles, visit, [](uint32_t) {});
}

/// Some of the items: tests that take a bounded time. None are left once the sink is over.
template <class Source, class Sink, class Visit, class Prefetch>
void visit_some(const Source& source, const Sink& sink, ItemRange& items, LeafTiles& tiles, const Visit& visit,
                const Prefetch& prefetch) {
  constexpr uint64_t kTests = 4096;
  if (sink.is_over()) items.first = items.end;
  for (uint64_t tests = kTests; tests > 0 && !items.is_over(); ++items.first, items.part = 0)
    if (!visit_tiles(source, items.first, items.part, tests, tiles, visit, prefetch)) return;
}

}  // namespace collided
