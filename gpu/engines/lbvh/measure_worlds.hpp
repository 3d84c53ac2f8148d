#pragma once
// What the stages have to know of each world of a set: how large it and its triangles are, and the scale of its filter.
// They are those of a scene of its own, so that its contacts are.

#include "gpu/base/extent.hpp"
#include "gpu/boxes/boxes.hpp"
#include "gpu/exec/counted.hpp"
#include "gpu/narrow/coplanarity_filter.hpp"

namespace collided {

/// One item for each world.
struct MeasureWorlds {
  static constexpr uint32_t kGroupSize = 256;
  struct Shared {
    Box<float> bounds[kGroupSize];
    uint64_t extents;
  };

  Span<const Box<float>> boxes;
  uint32_t triangles;  ///< of a world
  double thickness;
  Box<float>* bounds;  ///< of each world, like what follows
  uint64_t* extents;
  FilterScale* filters;

  COLLIDED_HD void operator()(uint64_t world, const Group& group, Shared& shared) const {
    const uint64_t first = world * triangles;
    Box<float> own = no_box();
    for (uint32_t k = group.rank; k < triangles; k += group.size) own = join(own, boxes[first + k]);
    shared.bounds[group.rank] = own;
    if (group.rank == 0) shared.extents = 0;
    for (uint32_t half = group.size / 2; half > 0; half /= 2) {
      group.sync();
      if (group.rank < half)
        shared.bounds[group.rank] = join(shared.bounds[group.rank], shared.bounds[group.rank + half]);
    }
    group.sync();
    const Box<float> all = shared.bounds[0];
    uint64_t sum = 0;
    for (uint32_t k = group.rank; k < triangles; k += group.size) sum += extent_of(boxes[first + k], all);
    add_all(shared.extents, sum);
    group.sync();
    if (group.rank != 0) return;
    bounds[world] = all;
    extents[world] = shared.extents;
    filters[world] = filter_within(all, thickness);
  }
};

}  // namespace collided
