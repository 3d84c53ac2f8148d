#pragma once
// The search for pairs on CPU cores: a source's items, member against member, four at a time.

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

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

/// Holds the members of a large leaf sorted by id, which groups them by mesh, and the meshes of each tile. Tiles that
/// may not touch are skipped before their boxes are loaded: 700 meshes in one place that are masked from each other
/// make millions of such pairs of tiles.
class LeafMeshes {
 public:
  /// Fewer members are tested sooner than they are sorted.
  static constexpr uint32_t kFewest = 16 * kTile;

  template <class Source, class Work>
  static bool pays(const Source& source, const Work& work) {
    return source.filter.has_rules() && source.by_start.empty() && work.leaf.count >= kFewest;
  }
  template <class Source, class Work>
  void load(const Source& source, const Work& work) {
    members_.assign(work.members, work.members + work.leaf.count);
    if (!std::is_sorted(members_.begin(), members_.end())) std::sort(members_.begin(), members_.end());
    tiles_.assign(tiles_of(work.leaf.count), {});
    blocks_.assign((tiles_.size() + kTilesOfBlock - 1) / kTilesOfBlock, {});
    for (uint32_t k = 0; k < work.leaf.count; ++k) tiles_[k / kTile].add(source.filter.meshes_of(members_[k]));
    for (uint32_t tile = 0; tile < tiles_.size(); ++tile) blocks_[tile / kTilesOfBlock].add(tiles_[tile]);
  }
  const uint32_t* members() const { return members_.data(); }

  /// The first tile from `column` on, before `end`, that tile `row` may touch; else `end`.
  uint32_t next(const PairFilter& filter, uint32_t row, uint32_t column, uint32_t end) const {
    while (column < end) {
      if (column % kTilesOfBlock == 0 && !filter.may_pass(tiles_[row], blocks_[column / kTilesOfBlock]))
        column += kTilesOfBlock;
      else if (!filter.may_pass(tiles_[row], tiles_[column]))
        ++column;
      else
        return column;
    }
    return end;
  }

 private:
  static constexpr uint32_t kTilesOfBlock = 32;

  std::vector<uint32_t> members_;
  std::vector<MeshesTogether> tiles_, blocks_;
};

/// Tiles of the leaf at hand, which several items in a row work on.
class LeafTiles {
 public:
  /// Sorts the members of the work's leaf where that pays. Null: it does not.
  template <class Source, class Work>
  const LeafMeshes* sort(const Source& source, Work& work) {
    if (!LeafMeshes::pays(source, work)) return nullptr;
    if (sorted_ != work.members) {
      sorted_ = work.members;
      meshes_.load(source, work);
      row_.members = nullptr;
      for (Slot& column : columns_) column.members = nullptr;
    }
    work.members = meshes_.members();
    return &meshes_;
  }

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
  const uint32_t* sorted_ = nullptr;  ///< the members that `meshes_` is of
  LeafMeshes meshes_;
};

/// The tiles of threads that rest, for those that go on: a large leaf takes longer to sort than some threads work on
/// it.
class SpareTiles {
 public:
  std::unique_ptr<LeafTiles> take() {
    const std::lock_guard lock(mutex_);
    if (spare_.empty()) return std::make_unique<LeafTiles>();
    auto tiles = std::move(spare_.back());
    spare_.pop_back();
    return tiles;
  }
  void give_back(std::unique_ptr<LeafTiles> tiles) {
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(tiles));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<LeafTiles>> spare_;
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
  auto work = source.work(item);
  const LeafMeshes* meshes = tiles.sort(source, work);
  const uint32_t rows = min(kTile, work.leaf.count - work.row);
  uint32_t first = work.first_column + static_cast<uint32_t>(part) * kTile;
  for (; first < work.end_column && tests > 0; first += kTile, ++part) {
    if (meshes != nullptr) {
      const uint32_t tile = meshes->next(source.filter, work.row / kTile, first / kTile, tiles_of(work.end_column));
      tests -= min(tests, uint64_t{kTile});  // about what that takes
      part += tile - first / kTile, first = tile * kTile;
      if (first >= work.end_column) break;
    }
    const BoxTile& row = tiles.rows(source, work, rows, prefetch);
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
