#pragma once
// Elements that are no triangles: loose edges, such as the segments of a hair, and loose points, such as particles.
// They are held as triangles (a, b, b) and (a, a, a), so that whatever works on triangles works on them.
//
// Pairs of features are those of any scene: each vertex with each triangle, each edge with each edge, whatever elements
// they are of. An edge has its ends; so this covers all that may meet, but for points that no triangle and no edge has.
// Those are tested, as vertex-triangle pairs, with loose edges and with each other: once, the point of the lower
// element as the vertex.

#include "gpu/base/host_device.hpp"
#include "gpu/search/elementary_numbers.hpp"

namespace collided {

/// What an element is to the tests of features.
enum class ElementRole : uint32_t {
  kTriangle,
  kLooseEdge,
  kLoosePoint,
  kDuplicate,  ///< a loose one, all of which an earlier element of its mesh has
};

/// Whether the corners are those of a loose edge or point.
template <class Corners>
COLLIDED_HD bool is_loose(const Corners& t) {
  return t.y == t.z;
}

/// Ownership bits have the role on top.
constexpr int kRoleBit = 6;
COLLIDED_HD constexpr ElementRole role_of(uint32_t owned) { return static_cast<ElementRole>(owned >> kRoleBit); }

/// For scenes of triangles alone.
struct TrianglesAlone {
  COLLIDED_HD static constexpr uint32_t wanted_tests(ElementRole, ElementRole, bool) { return ~0u; }
};
/// For scenes with loose elements.
struct MixedElements {
  /// One bit for each test (search/elementary_numbers.hpp) of two elements that is not left to others.
  COLLIDED_HD static constexpr uint32_t wanted_tests(ElementRole a, ElementRole b, bool a_is_lower) {
    return (takes(a, b, a_is_lower) ? 7u : 0u) | (takes(b, a, !a_is_lower) ? 7u << 3 : 0u) | ~0u << kFirstEdgeEdge;
  }

 private:
  /// Whether vertices of the first are tested with the second.
  COLLIDED_HD static constexpr bool takes(ElementRole vertex, ElementRole element, bool vertex_is_lower) {
    if (element == ElementRole::kTriangle) return true;
    if (vertex != ElementRole::kLoosePoint) return false;
    return element == ElementRole::kLooseEdge || (element == ElementRole::kLoosePoint && vertex_is_lower);
  }
};

}  // namespace collided
