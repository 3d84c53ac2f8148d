#pragma once
// Which triangles and loose edges are around a vertex.

#include "gpu/base/worlds.hpp"

namespace collided {

/// The elements around each vertex. None where a scene tells no features.
struct Fans {
  Span<const uint32_t> begin;     ///< of each vertex's; one more at the end
  Span<const uint32_t> elements;  ///< ascending for each vertex
  WorldTable<Vec3<uint32_t>> corners;
  WorldShape shape;  ///< of the scene; the tables are of one world

  COLLIDED_HD bool are_known() const { return !begin.empty(); }
  COLLIDED_HD uint32_t size(uint32_t v) const {
    const uint32_t of_first = v % shape.vertices;
    return begin[of_first + 1] - begin[of_first];
  }
  /// use(corners of the element) for each around v, in order, until it returns false. The two corners of a loose edge
  /// are a, b, b.
  template <class Use>
  COLLIDED_HD void for_each(uint32_t v, const Use& use) const {
    const uint32_t world = v / shape.vertices, of_first = v - world * shape.vertices;
    for (uint32_t i = begin[of_first]; i < begin[of_first + 1]; ++i)
      if (!use(corners[world * shape.triangles + elements[i]])) return;
  }
};

}  // namespace collided
