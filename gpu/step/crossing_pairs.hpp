#pragma once
// Pairs of triangles an edge of one of which may go through the other, and what becomes of them.

#include "gpu/narrow/crossings.hpp"
#include "gpu/search/excluded_pairs.hpp"
#include "gpu/search/loose_elements.hpp"
#include "gpu/step/sinks.hpp"

namespace collided {

/// They share one vertex at most, and one is a triangle.
struct CrossingPairSink : TrianglePairSink {
  COLLIDED_HD bool take(uint32_t a, uint32_t b) const {
    uint64_t key;
    return !keeps(a, b, key) || pairs.push(key);
  }
  COLLIDED_HD bool keeps(uint32_t a, uint32_t b, uint64_t& key) const {
    const Triangle p = triangles[a], q = triangles[b];
    key = pack_ids(a, b);
    return common_corners(p, q) < 2 && !(is_loose(p) && is_loose(q));
  }
};

/// Tests the edges that each triangle of a pair owns with the other triangle. Signs in float rule most of them out.
template <class Real>
struct TestCrossings {
  const Vec3<Real>* positions;
  WorldTable<Triangle> corners, sides;
  Span<const uint8_t> owned;  ///< as in ElementaryTests
  VertexRings rings;
  Span<const uint64_t> pairs;
  ContactSink<Real> contacts;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (contacts.early_exit.is_over()) return;
    const uint32_t a = first_id(pairs[i]), b = second_id(pairs[i]);
    const Triangle p = corners[a], q = corners[b];
    uint32_t of_p = edges_of(a, p, q), of_q = edges_of(b, q, p);
    if ((of_p | of_q) == 0) return;
    TriangleDifferences<float> rough;
    if (load_differences(p, q, positions, rough)) {
      of_p = EdgesFromTriangle<float, false>(rough).left_of(of_p);
      of_q = EdgesFromTriangle<float, true>(rough).left_of(of_q);
    }
    if ((of_p | of_q) != 0) look_closely(a, of_p, b, of_q);
  }

 private:
  COLLIDED_HD COLLIDED_CALLED void look_closely(uint32_t a, uint32_t of_a, uint32_t b, uint32_t of_b) const {
    TriangleDifferences<double> pair;
    if (!load_differences(corners[a], corners[b], positions, pair)) pair = {};  // all in one place: nothing is certain
    if (of_a != 0) test(of_a, EdgesFromTriangle<double, false>(pair), a, b);
    if (of_b != 0) test(of_b, EdgesFromTriangle<double, true>(pair), b, a);
  }
  /// One bit for each edge of `element` that it owns and that may go through the triangle.
  COLLIDED_HD uint32_t edges_of(uint32_t element, const Triangle& ids, const Triangle& triangle) const {
    uint32_t edges = is_loose(triangle) ? 0 : owned[element] >> 3 & 7u;
    for (int k = 0; k < 3; ++k) {
      const uint32_t v = at(ids, k);
      if (is_left_out(v, triangle)) edges &= ~(1u << k | 1u << (k + 2) % 3);
    }
    return edges;
  }
  COLLIDED_HD bool is_left_out(uint32_t vertex, const Triangle& triangle) const {
    const bool is_corner = vertex == triangle.x || vertex == triangle.y || vertex == triangle.z;
    return is_corner || (rings.is_needed() && rings.connect(vertex, triangle));
  }
  template <class Edges>
  COLLIDED_HD void test(uint32_t which, const Edges& edges, uint32_t element, uint32_t triangle) const {
    for_each_corner([&](int k) {
      const Crossing seen = (which >> k & 1u) != 0 ? edges.look_closely(k) : Crossing::kNone;
      if (seen != Crossing::kNone) report(element, k, triangle, seen == Crossing::kSure);
    });
  }
  COLLIDED_HD void report(uint32_t element, int k, uint32_t triangle, bool is_sure) const {
    const uint64_t key = pack_ids(at(sides[element], k), triangle);
    if (!is_sure) return contacts.report(key, {0, Real(0), Real(0), Real(0), kFlagNear});
    const Triangle p = corners[element], t = corners[triangle];
    double weights[2];
    find_weights({point(at(p, k)), point(at(p, (k + 1) % 3))}, {point(t.x), point(t.y), point(t.z)}, weights);
    contacts.report(key, {0, Real(0), static_cast<Real>(weights[0]), static_cast<Real>(weights[1]), kFlagCertified});
  }
  COLLIDED_HD Vec3<double> point(uint32_t vertex) const { return convert<double>(positions[vertex]); }
  COLLIDED_HD static uint32_t at(const Triangle& t, int k) { return k == 0 ? t.x : k == 1 ? t.y : t.z; }
};

}  // namespace collided
