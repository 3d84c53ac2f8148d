#pragma once
// The search for pairs by walks through a tree, on CPU cores. A source makes a walk of each item; the walk goes a step
// at a time and says when it has found a partner.

#include <cstdint>

namespace collided {

/// visit(the item's triangle, partner) for the pairs of an item. Returns how many steps that took.
template <class Source, class Visit>
uint64_t walk_item(const Source& source, uint64_t item, const Visit& visit) {
  auto walk = source.walk(item);
  uint64_t steps = 0;
  for (; !walk.is_over(); ++steps)
    if (source.step(walk)) visit(walk.triangle, walk.found);
  return steps;
}

}  // namespace collided
