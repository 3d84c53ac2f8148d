#pragma once
// Section 3.3: vertex-triangle and edge-edge candidates of a triangle pair.
// R-triangles (Curtis, Tamstorf and Manocha 2008): each vertex and edge belongs to the triangle of lowest id that
// has it, and only its owner's pairs test it, so that every candidate comes up exactly once. Triangles that share a
// vertex are not skipped: their other features may touch. Features that share a vertex are no pair.

#include "gpu/broad/boxes.hpp"
#include "gpu/broad/pair_tests.hpp"

namespace collided {

COLLIDED_HD inline uint64_t pack_ids(uint32_t first, uint32_t second) { return uint64_t{first} << 32 | second; }
COLLIDED_HD inline uint32_t first_id(uint64_t key) { return static_cast<uint32_t>(key >> 32); }
COLLIDED_HD inline uint32_t second_id(uint64_t key) { return static_cast<uint32_t>(key); }

/// Bits 0-2: owns its corner 0, 1, 2; bits 3-5: owns its edge 0-1, 1-2, 2-0.
struct Ownership {
  Span<const uint8_t> mask;
};

template <class Real>
struct FindVertexTrianglePairs {
  Motion<Real> motion;
  Span<const Triangle> triangles;
  Ownership owned;
  Span<const TrianglePair> pairs;
  AppendList<uint64_t> candidates;  ///< vertex, triangle

  COLLIDED_HD void operator()(uint64_t i) const {
    const TrianglePair pair = pairs[i];
    test(pair.a, pair.b);
    test(pair.b, pair.a);
  }

 private:
  COLLIDED_HD void test(uint32_t owner, uint32_t triangle) const {
    const uint32_t mask = owned.mask[owner] & 7u;
    if (mask == 0) return;
    const Triangle corners = triangles[owner], t = triangles[triangle];
    const Box<Real> box = motion.triangle_box(t.x, t.y, t.z);
    const uint32_t vertex[3] = {corners.x, corners.y, corners.z};
    for (int k = 0; k < 3; ++k) {
      const uint32_t v = vertex[k];
      if ((mask >> k & 1u) == 0 || v == t.x || v == t.y || v == t.z) continue;
      if (overlap(motion.vertex_box(v), box)) candidates.push(pack_ids(v, triangle));
    }
  }
};

template <class Real>
struct FindEdgeEdgePairs {
  Motion<Real> motion;
  Span<const Triangle> triangles;
  Span<const Triangle> triangle_edges;
  Ownership owned;
  Span<const TrianglePair> pairs;
  AppendList<uint64_t> candidates;  ///< lower edge, higher edge

  COLLIDED_HD void operator()(uint64_t i) const {
    const TrianglePair pair = pairs[i];
    const uint32_t mask_a = owned.mask[pair.a] >> 3, mask_b = owned.mask[pair.b] >> 3;
    if (mask_a == 0 || mask_b == 0) return;
    const Edges a(*this, pair.a), b(*this, pair.b);
    for (int k = 0; k < 3; ++k) {
      if ((mask_a >> k & 1u) == 0) continue;
      const Box<Real> box = motion.edge_box(a.from[k], a.to[k]);
      for (int m = 0; m < 3; ++m) {
        if ((mask_b >> m & 1u) == 0 || shares_vertex(a, k, b, m)) continue;
        if (overlap(box, motion.edge_box(b.from[m], b.to[m])))
          candidates.push(pack_ids(smaller(a.id[k], b.id[m]), larger(a.id[k], b.id[m])));
      }
    }
  }

 private:
  struct Edges {
    uint32_t id[3], from[3], to[3];
    COLLIDED_HD Edges(const FindEdgeEdgePairs& scene, uint32_t triangle) {
      const Triangle t = scene.triangles[triangle], e = scene.triangle_edges[triangle];
      id[0] = e.x, id[1] = e.y, id[2] = e.z;
      from[0] = t.x, from[1] = t.y, from[2] = t.z;
      to[0] = t.y, to[1] = t.z, to[2] = t.x;
    }
  };
  COLLIDED_HD static bool shares_vertex(const Edges& a, int k, const Edges& b, int m) {
    return a.from[k] == b.from[m] || a.from[k] == b.to[m] || a.to[k] == b.from[m] || a.to[k] == b.to[m];
  }
};

}  // namespace collided
