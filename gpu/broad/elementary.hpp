#pragma once
// Section 3.3: vertex-triangle and edge-edge candidates of a triangle pair.
// R-triangles (Curtis, Tamstorf and Manocha 2008): each vertex and edge belongs to the triangle of lowest id that
// has it, and only its owner's pairs test it, so that every candidate comes up exactly once. Triangles that share a
// vertex are not skipped: their other features may touch. Features that share a vertex are no pair.

#include "gpu/broad/boxes.hpp"
#include "gpu/math/points.hpp"

namespace collided {

COLLIDED_HD inline uint64_t pack_ids(uint32_t first, uint32_t second) { return uint64_t{first} << 32 | second; }
COLLIDED_HD inline uint32_t first_id(uint64_t key) { return static_cast<uint32_t>(key >> 32); }
COLLIDED_HD inline uint32_t second_id(uint64_t key) { return static_cast<uint32_t>(key); }

/// Which features of two triangles a and b a candidate takes, by number: 0-2: corner of a, triangle b; 3-5: corner of
/// b, triangle a; 6 + 3k + m: edge k of a, edge m of b.
constexpr int kFirstEdgeEdge = 6, kElementaryTests = 15;

/// A candidate's key and its points, in the order of Stencil.
template <class Real>
struct CandidatePoints {
  uint64_t key;  ///< vertex, triangle; or lower edge, higher edge
  FeaturePoints<Real> points;
};

template <class Real>
struct ElementaryTests {
  Span<const TriangleRecord<Real>> records;
  Real inflation;  ///< half the thickness
  bool vertex_triangle, edge_edge;

  /// One bit for each test whose boxes overlap.
  COLLIDED_HD uint32_t operator()(uint32_t a, uint32_t b) const {
    const Features p(records[a], inflation), q(records[b], inflation);
    uint32_t found = 0;
    if (vertex_triangle) found |= corners_in(p, q) | corners_in(q, p) << 3;
    if (edge_edge) found |= edges_across(p, q) << kFirstEdgeEdge;
    return found;
  }

  COLLIDED_HD CandidatePoints<Real> vertex_triangle_points(uint32_t a, uint32_t b, int test) const {
    const uint32_t triangle = test < 3 ? b : a;
    const int corner = test < 3 ? test : test - 3;
    const TriangleRecord<Real>&p = records[test < 3 ? a : b], &q = records[triangle];
    return {pack_ids(p.vertex_id(corner), triangle),
            {{p.start[corner], q.start[0], q.start[1], q.start[2]}, {p.end[corner], q.end[0], q.end[1], q.end[2]}}};
  }
  COLLIDED_HD CandidatePoints<Real> edge_edge_points(uint32_t a, uint32_t b, int test) const {
    const TriangleRecord<Real>&p = records[a], &q = records[b];
    const int k = (test - kFirstEdgeEdge) / 3, m = (test - kFirstEdgeEdge) % 3;
    const int k1 = k == 2 ? 0 : k + 1, m1 = m == 2 ? 0 : m + 1;
    const uint32_t e = p.edge_id(k), f = q.edge_id(m);
    return {pack_ids(smaller(e, f), larger(e, f)),
            {{p.start[k], p.start[k1], q.start[m], q.start[m1]}, {p.end[k], p.end[k1], q.end[m], q.end[m1]}}};
  }

 private:
  /// Boxes of a triangle's corners over the step, and what it owns.
  struct Features {
    Box<Real> corner[3];
    uint32_t vertex[3];
    uint32_t owned;

    COLLIDED_HD Features(TriangleRecord<Real> r, Real inflation) : owned(0) {
      for (int k = 0; k < 3; ++k) {
        const Box<Real> a{r.start[k], r.start[k]}, b{r.end[k], r.end[k]};
        corner[k] = inflate(join(a, b), inflation);
        vertex[k] = r.vertex_id(k);
        owned |= (r.vertex[k] >> 31) << k | (r.edge[k] >> 31) << (3 + k);
      }
    }
    COLLIDED_HD Box<Real> edge(int k) const { return join(corner[k], corner[k == 2 ? 0 : k + 1]); }
    COLLIDED_HD Box<Real> triangle() const { return join(corner[0], join(corner[1], corner[2])); }
    COLLIDED_HD bool owns_vertex(int k) const { return (owned >> k & 1u) != 0; }
    COLLIDED_HD bool owns_edge(int k) const { return (owned >> (3 + k) & 1u) != 0; }
    COLLIDED_HD bool has(uint32_t v) const { return v == vertex[0] || v == vertex[1] || v == vertex[2]; }
  };

  COLLIDED_HD static uint32_t corners_in(const Features& p, const Features& q) {
    const Box<Real> box = q.triangle();
    uint32_t found = 0;
    for (int k = 0; k < 3; ++k)
      if (p.owns_vertex(k) && overlap(p.corner[k], box) && !q.has(p.vertex[k])) found |= 1u << k;
    return found;
  }
  COLLIDED_HD static uint32_t edges_across(const Features& p, const Features& q) {
    uint32_t found = 0;
    for (int k = 0; k < 3; ++k) {
      if (!p.owns_edge(k)) continue;
      const Box<Real> box = p.edge(k);
      const uint32_t from = p.vertex[k], to = p.vertex[k == 2 ? 0 : k + 1];
      for (int m = 0; m < 3; ++m) {
        if (!q.owns_edge(m) || !overlap(box, q.edge(m))) continue;
        const uint32_t v = q.vertex[m], w = q.vertex[m == 2 ? 0 : m + 1];
        if (from != v && from != w && to != v && to != w) found |= 1u << (3 * k + m);
      }
    }
    return found;
  }
};

}  // namespace collided
