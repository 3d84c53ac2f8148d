#pragma once
// The search for pairs by walks through a tree, on CPU cores. A source makes a walk of each item; the walk goes a step
// at a time and says when it has found a partner.

#include <cstdint>

#include "gpu/exec/cpu/cpu_loops.hpp"

namespace collided {

/// visit(the item's triangle, partner) for the pairs of a walk, until `most` steps are done. Returns how many it did.
template <class Walk, class Source, class Visit>
uint64_t go_on(const Source& source, Walk& walk, uint64_t most, const Visit& visit) {
  uint64_t steps = 0;
  for (; !walk.is_over() && steps < most; ++steps)
    if (source.step(walk)) visit(walk.triangle, walk.found);
  return steps;
}

/// The whole walk of an item.
template <class Source, class Visit>
uint64_t walk_item(const Source& source, uint64_t item, const Visit& visit) {
  auto walk = source.walk(item);
  return go_on(source, walk, ~uint64_t{0}, visit);
}

/// Some of the items' walks: steps that take a bounded time. None are left once the sink is over. A walk that is left
/// half done goes on at node `part` - 1.
template <class Source, class Sink, class Visit>
uint64_t walk_some(const Source& source, const Sink& sink, ItemRange& items, const Visit& visit) {
  constexpr uint64_t kSteps = 2048;
  if (sink.is_over()) items.first = items.end;
  uint64_t steps = 0;
  for (; steps < kSteps && !items.is_over(); ++items.first, items.part = 0) {
    auto walk = source.walk(items.first);
    if (items.part != 0) walk.node = static_cast<uint32_t>(items.part - 1);
    steps += go_on(source, walk, kSteps - steps, visit);
    items.part = uint64_t{walk.node} + 1;
    if (!walk.is_over()) break;
  }
  return steps;
}

}  // namespace collided
