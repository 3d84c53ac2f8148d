#pragma once
// Section 3.3: vertex-triangle and edge-edge candidates of a triangle pair.
// R-triangles (Curtis, Tamstorf and Manocha 2008): each vertex and edge belongs to the triangle of lowest id that
// has it, loose elements (search/loose_elements.hpp) among them, and only its owner's pairs test it, so that every
// candidate comes up exactly once. Triangles that share a vertex are not skipped: their other features may touch.
// Features that share a vertex are no pair.

#include "gpu/base/keys.hpp"
#include "gpu/base/points.hpp"
#include "gpu/search/boxes.hpp"
#include "gpu/search/elementary_numbers.hpp"
#include "gpu/search/loose_elements.hpp"

namespace collided {

/// A candidate's key and its points, in the order of Stencil.
template <class Real>
struct CandidatePoints {
  uint64_t key;  ///< vertex, triangle; or lower edge, higher edge
  FeaturePoints<Real> points;
};

/// What the boxes of a triangle's features are inflated by: half the thickness.
template <class Real>
struct EvenInflation {
  Real half;

  COLLIDED_HD Real of(uint32_t) const { return half; }
};
/// And how far its mesh may be from its path.
template <class Real>
struct InflationByTriangle {
  Real half;
  Span<const Real> inflations;  ///< of each triangle; empty: no mesh turns

  COLLIDED_HD Real of(uint32_t triangle) const { return inflations.empty() ? half : inflations[triangle]; }
};

template <class Real, class Inflation = EvenInflation<Real>, class Elements = TrianglesAlone>
struct ElementaryTests {
  using Number = Real;

  Span<const TriangleRecord<Real>> records;
  Span<const uint8_t> owned;  ///< bits 0-2: corner 0, 1, 2; bits 3-5: edge 0-1, 1-2, 2-0; from kRoleBit on: its role
  Inflation inflation;
  bool vertex_triangle, edge_edge;

  /// One bit for each test (search/elementary_numbers.hpp) that is this pair's to make; a < b.
  COLLIDED_HD uint32_t tests_of(uint32_t a, uint32_t b) const {
    const uint32_t p = owned[a], q = owned[b];
    uint32_t tests = 0;
    if (vertex_triangle) tests = (p & 7u) | (q & 7u) << 3;
    if (edge_edge) {
      const uint32_t edges = q >> 3 & 7u;
      for (int k = 0; k < 3; ++k) tests |= (p >> (3 + k) & 1u) * edges << edge_edge_test(k, 0);
    }
    return tests & wanted_tests(role_of(p), role_of(q), true);
  }
  /// Those of a and b that are not left to other elements, by their roles.
  COLLIDED_HD static constexpr uint32_t wanted_tests(ElementRole a, ElementRole b, bool a_is_lower) {
    return Elements::wanted_tests(a, b, a_is_lower);
  }

  /// Which corners and edges of a triangle are to be tested; bits as in `owned`.
  COLLIDED_HD uint32_t tested_of(uint32_t triangle) const {
    return owned[triangle] & ((vertex_triangle ? 7u : 0u) | (edge_edge ? 7u << 3 : 0u));
  }
  COLLIDED_HD ElementRole role(uint32_t triangle) const { return role_of(owned[triangle]); }
  /// Box of a corner's path; those of edges and triangles are joined from them.
  COLLIDED_HD Box<Real> corner_box(uint32_t triangle, int k) const {
    return inflate(records[triangle].corner[k].swept(), inflation.of(triangle));
  }
  COLLIDED_HD Triangle vertices_of(uint32_t triangle) const {
    const TriangleRecord<Real>& t = records[triangle];
    return {t.corner[0].vertex_id(), t.corner[1].vertex_id(), t.corner[2].vertex_id()};
  }
  COLLIDED_HD Triangle edges_of(uint32_t triangle) const {
    const TriangleRecord<Real>& t = records[triangle];
    return {t.corner[0].edge_id(), t.corner[1].edge_id(), t.corner[2].edge_id()};
  }

  /// Whether the features share no vertex and their boxes overlap.
  COLLIDED_HD bool vertex_triangle_overlap(uint32_t a, uint32_t b, int test) const {
    const CornerRecord<Real> v = vertex_corner(a, b, test);
    const TriangleRecord<Real>& t = records[test < 3 ? b : a];
    const EdgeRecord<Real> e = t.edge[0], f = t.edge[1];
    const uint32_t id = v.vertex_id();
    if (id == e.from || id == f.from || id == f.to) return false;
    return overlap(inflate(v.swept(), inflation.of(test < 3 ? a : b)), join(e.box(), f.box()));
  }
  COLLIDED_HD bool edge_edge_overlap(uint32_t a, uint32_t b, int test) const {
    const EdgeRecord<Real> e = records[a].edge[first_edge_of(test)], f = records[b].edge[second_edge_of(test)];
    if (e.from == f.from || e.from == f.to || e.to == f.from || e.to == f.to) return false;
    return overlap(e.box(), f.box());
  }

  COLLIDED_HD CandidatePoints<Real> vertex_triangle_points(uint32_t a, uint32_t b, int test) const {
    const uint32_t triangle = test < 3 ? b : a;
    const CornerRecord<Real> v = vertex_corner(a, b, test);
    const TriangleRecord<Real>& t = records[triangle];
    const CornerRecord<Real> c0 = t.corner[0], c1 = t.corner[1], c2 = t.corner[2];
    return {pack_ids(v.vertex_id(), triangle),
            {{v.start, c0.start, c1.start, c2.start}, {v.end, c0.end, c1.end, c2.end}}};
  }
  COLLIDED_HD CandidatePoints<Real> edge_edge_points(uint32_t a, uint32_t b, int test) const {
    const EdgeCorners e(*this, a, b, test);
    const uint32_t f = e.a0.edge_id(), g = e.b0.edge_id();
    return {pack_ids(min(f, g), max(f, g)),
            {{e.a0.start, e.a1.start, e.b0.start, e.b1.start}, {e.a0.end, e.a1.end, e.b0.end, e.b1.end}}};
  }

 private:
  COLLIDED_HD CornerRecord<Real> vertex_corner(uint32_t a, uint32_t b, int test) const {
    return records[test < 3 ? a : b].corner[test < 3 ? test : test - 3];
  }
  COLLIDED_HD static int next(int k) { return k == 2 ? 0 : k + 1; }
  struct EdgeCorners {
    CornerRecord<Real> a0, a1, b0, b1;
    COLLIDED_HD EdgeCorners(const ElementaryTests& scene, uint32_t a, uint32_t b, int test) {
      const int k = first_edge_of(test), m = second_edge_of(test);
      const TriangleRecord<Real>&p = scene.records[a], &q = scene.records[b];
      a0 = p.corner[k], a1 = p.corner[next(k)], b0 = q.corner[m], b1 = q.corner[next(m)];
    }
  };
};

}  // namespace collided
