#pragma once
// Section 3.3: vertex-triangle and edge-edge candidates of a triangle pair.
// R-triangles (Curtis, Tamstorf and Manocha 2008): each vertex and edge belongs to the triangle of lowest id that
// has it, loose elements (search/loose_elements.hpp) among them, and only its owner's pairs test it, so that every
// candidate comes up exactly once. Triangles that share a vertex are not skipped: their other features may touch.
// Features that share a vertex are no pair.

#include "gpu/base/keys.hpp"
#include "gpu/boxes/boxes.hpp"
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
  static constexpr bool kDiffers = false;  ///< from triangle to triangle
  Real half;

  COLLIDED_HD Real of(uint32_t) const { return half; }
};
/// And its mesh's half thickness, and how far that may be from its path.
template <class Real>
struct InflationByTriangle {
  static constexpr bool kDiffers = true;
  Real half;
  Span<const Real> inflations;  ///< of each triangle; empty: all are `half`

  COLLIDED_HD Real of(uint32_t triangle) const { return inflations.empty() ? half : inflations[triangle]; }
};

template <class Real, class Inflation = EvenInflation<Real>, class Elements = TrianglesAlone>
struct ElementaryTests {
  using Number = Real;

  TriangleRecords<Real> records;
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
  /// Box of a corner's path, as records have it; those of edges and triangles are joined from them.
  COLLIDED_HD Box<float> corner_box(uint32_t triangle, int k) const {
    return records[triangle].corner[k].box(inflation.of(triangle));
  }
  COLLIDED_HD Triangle vertices_of(uint32_t triangle) const {
    const TriangleRecord<Real>& t = records[triangle];
    return {t.corner[0].vertex, t.corner[1].vertex, t.corner[2].vertex};
  }
  COLLIDED_HD Triangle edges_of(uint32_t triangle) const {
    const TriangleRecord<Real>& t = records[triangle];
    return {t.corner[0].edge, t.corner[1].edge, t.corner[2].edge};
  }

  /// Whether the features share no vertex and their boxes overlap.
  COLLIDED_HD bool vertex_triangle_overlap(uint32_t a, uint32_t b, int test) const {
    const CornerRecord<Real> v = vertex_corner(a, b, test);
    const TriangleRecord<Real>& t = records[test < 3 ? b : a];
    const EdgeRecord e = t.edge[0], f = t.edge[1];
    if (v.vertex == e.from || v.vertex == f.from || v.vertex == f.to) return false;
    const uint32_t of_vertex = test < 3 ? a : b, triangle = test < 3 ? b : a;
    const Box<float> box = v.box(inflation.of(of_vertex)), other = join(e.box(), f.box());
    return overlap(box, other) &&
           confirms<FirstFeature::kVertex>(box, other, {{v.vertex, e.from, f.from, f.to}}, of_vertex, triangle);
  }
  COLLIDED_HD bool edge_edge_overlap(uint32_t a, uint32_t b, int test) const {
    const EdgeRecord e = records[a].edge[first_edge_of(test)], f = records[b].edge[second_edge_of(test)];
    if (e.from == f.from || e.from == f.to || e.to == f.from || e.to == f.to) return false;
    return overlap(e.box(), f.box()) &&
           confirms<FirstFeature::kEdge>(e.box(), f.box(), {{e.from, e.to, f.from, f.to}}, a, b);
  }
  /// Whether the boxes of two features, one of triangle a, one of b, overlap if those in their records, p and q, do.
  template <FirstFeature kFirst>
  COLLIDED_HD bool confirms(const Box<float>& p, const Box<float>& q, const Stencil& stencil, uint32_t a,
                            uint32_t b) const {
    if (!kRoundsBoxes<Real> || surely_overlap(p, q)) return true;
    return BoxesOfPair<kFirst, Real>{records.paths.data, stencil, inflation.of(a), inflation.of(b)}.overlap();
  }

  COLLIDED_HD CandidatePoints<Real> vertex_triangle_points(uint32_t a, uint32_t b, int test) const {
    const uint32_t triangle = test < 3 ? b : a;
    const CornerRecord<Real> v = vertex_corner(a, b, test);
    const TriangleRecord<Real>& t = records[triangle];
    const EdgeRecord &e = t.edge[0], &f = t.edge[1];  // which the test of boxes has read
    return {pack_ids(v.vertex, triangle),
            points_of(records.path(v, v.vertex), records.path(t.corner[0], e.from), records.path(t.corner[1], f.from),
                      records.path(t.corner[2], f.to))};
  }
  COLLIDED_HD CandidatePoints<Real> edge_edge_points(uint32_t a, uint32_t b, int test) const {
    const int k = first_edge_of(test), m = second_edge_of(test);
    const TriangleRecord<Real>&p = records[a], &q = records[b];
    const CornerRecord<Real> a0 = p.corner[k], b0 = q.corner[m];
    const EdgeRecord &e = p.edge[k], &f = q.edge[m];
    return {pack_ids(min(a0.edge, b0.edge), max(a0.edge, b0.edge)),
            points_of(records.path(a0, e.from), records.path(p.corner[next(k)], e.to), records.path(b0, f.from),
                      records.path(q.corner[next(m)], f.to))};
  }

 private:
  COLLIDED_HD CornerRecord<Real> vertex_corner(uint32_t a, uint32_t b, int test) const {
    return records[test < 3 ? a : b].corner[test < 3 ? test : test - 3];
  }
  COLLIDED_HD static int next(int k) { return k == 2 ? 0 : k + 1; }
  COLLIDED_HD static FeaturePoints<Real> points_of(const Path<Real>& a, const Path<Real>& b, const Path<Real>& c,
                                                   const Path<Real>& d) {
    return {{a.start, b.start, c.start, d.start}, {a.end, b.end, c.end, d.end}};
  }
};

}  // namespace collided
