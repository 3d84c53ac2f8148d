#pragma once
// What the octree's stages keep on the backend.

#include "gpu/engines/octree/leaf_pairs.hpp"
#include "gpu/engines/octree/levels.hpp"
#include "gpu/engines/octree/refine.hpp"
#include "gpu/exec/buffer.hpp"

namespace collided {

/// The octree grid of one frame.
template <Executor Exec>
struct OctreeBuffers {
  explicit OctreeBuffers(Exec& exec)
      : wanted(exec, "octree"),
        counts(exec, "octree"),
        type(exec, "octree"),
        slot(exec, "octree"),
        root_cost(exec, "octree"),
        large(exec, "octree"),
        bricks(exec, "bricks"),
        reach(exec, "bricks"),
        brick_cost(exec, "bricks"),
        brick_items(exec, "bricks"),
        leaves(exec, "octree"),
        cursor(exec, "octree"),
        registered(exec, "registrations"),
        items(exec, "octree"),
        ordered(exec, "registrations"),
        by_start(exec, "octree") {}

  Buffer<ActiveLevels, Exec> wanted;
  Buffer<uint32_t, Exec> counts;
  Buffer<uint8_t, Exec> type;
  Buffer<uint32_t, Exec> slot;
  Buffer<float, Exec> root_cost;
  Buffer<uint32_t, Exec> large;  ///< triangles with many cells
  Buffer<Brick, Exec> bricks;
  Buffer<uint32_t, Exec> reach;
  Buffer<float, Exec> brick_cost;
  Buffer<BrickItem, Exec> brick_items;
  Buffer<Leaf, Exec> leaves;
  Buffer<uint32_t, Exec> cursor;
  Buffer<uint32_t, Exec> registered;
  Buffer<PairItem, Exec> items;
  Buffer<uint32_t, Exec> ordered;         ///< `registered` by control bits; kVss
  Buffer<MembersByStart, Exec> by_start;  ///< likewise
};

}  // namespace collided
