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

COLLIDED_HD inline uint32_t corner_at(const Triangle& t, int k) { return k == 0 ? t.x : k == 1 ? t.y : t.z; }

/// A pair of triangles by its place in a list, with one bit for each edge of both that may go through the other one.
struct PackedEdges {
  uint64_t pair;
  uint32_t of_first, of_second;

  COLLIDED_HD uint64_t packed() const { return pair << 6 | of_second << 3 | of_first; }
  COLLIDED_HD static PackedEdges unpacked(uint64_t packed) {
    return {packed >> 6, static_cast<uint32_t>(packed & 7u), static_cast<uint32_t>(packed >> 3 & 7u)};
  }
};

/// Lists the edges that each triangle of a pair owns, and that signs in float do not rule out. A GPU runs many more
/// threads of this than of what is left to do.
template <class Real>
struct RuleOutCrossings {
  const Vec3<Real>* positions;
  WorldTable<Triangle> corners;
  Span<const uint8_t> owned;  ///< as in ElementaryTests
  VertexRings rings;
  Span<const uint64_t> pairs;
  EarlyExit early_exit;
  AppendList<uint64_t> left;  ///< PackedEdges

  COLLIDED_HD void operator()(uint64_t i) const {
    if (early_exit.is_over()) return;
    const uint32_t a = first_id(pairs[i]), b = second_id(pairs[i]);
    const Triangle p = corners[a], q = corners[b];
    PackedEdges edges{i, edges_of(a, p, q), edges_of(b, q, p)};
    if ((edges.of_first | edges.of_second) == 0) return;
    TriangleDifferences<float> rough;
    if (load_differences(p, q, positions, rough)) {
      edges.of_first = EdgesFromTriangle<float, false>(rough).left_of(edges.of_first);
      edges.of_second = EdgesFromTriangle<float, true>(rough).left_of(edges.of_second);
    }
    if ((edges.of_first | edges.of_second) != 0) left.push(edges.packed());
  }

 private:
  /// One bit for each edge of `element` that it owns and that may go through the triangle.
  COLLIDED_HD uint32_t edges_of(uint32_t element, const Triangle& ids, const Triangle& triangle) const {
    uint32_t edges = is_loose(triangle) ? 0 : owned[element] >> 3 & 7u;
    for (int k = 0; k < 3; ++k) {
      const uint32_t v = corner_at(ids, k);
      if (is_left_out(v, triangle)) edges &= ~(1u << k | 1u << (k + 2) % 3);
    }
    return edges;
  }
  COLLIDED_HD bool is_left_out(uint32_t vertex, const Triangle& triangle) const {
    const bool is_corner = vertex == triangle.x || vertex == triangle.y || vertex == triangle.z;
    return is_corner || (rings.is_needed() && rings.connect(vertex, triangle));
  }
};

/// Tests these edges.
template <class Real>
struct TestCrossings {
  const Vec3<Real>* positions;
  WorldTable<Triangle> corners, sides;
  Span<const uint64_t> pairs;
  Span<const uint64_t> left;  ///< PackedEdges
  ContactSink<Real> contacts;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (contacts.early_exit.is_over()) return;
    const PackedEdges edges = PackedEdges::unpacked(left[i]);
    const uint32_t a = first_id(pairs[edges.pair]), b = second_id(pairs[edges.pair]);
    TriangleDifferences<double> pair;
    if (!load_differences(corners[a], corners[b], positions, pair)) pair = {};  // all in one place: nothing is certain
    if (edges.of_first != 0) test(edges.of_first, EdgesFromTriangle<double, false>(pair), a, b);
    if (edges.of_second != 0) test(edges.of_second, EdgesFromTriangle<double, true>(pair), b, a);
  }

 private:
  template <class Edges>
  COLLIDED_HD void test(uint32_t which, const Edges& edges, uint32_t element, uint32_t triangle) const {
    for_each_corner([&](int k) {
      const Crossing seen = (which >> k & 1u) != 0 ? edges.look_closely(k) : Crossing::kNone;
      if (seen != Crossing::kNone) report(element, k, triangle, seen == Crossing::kSure);
    });
  }
  COLLIDED_HD void report(uint32_t element, int k, uint32_t triangle, bool is_sure) const {
    const uint64_t key = pack_ids(corner_at(sides[element], k), triangle);
    if (!is_sure) return contacts.report(key, {0, Real(0), Real(0), Real(0), kFlagNear});
    const Triangle p = corners[element], t = corners[triangle];
    double weights[2];
    find_weights({point(corner_at(p, k)), point(corner_at(p, (k + 1) % 3))}, {point(t.x), point(t.y), point(t.z)},
                 weights);
    contacts.report(key, {0, Real(0), static_cast<Real>(weights[0]), static_cast<Real>(weights[1]), kFlagCertified});
  }
  COLLIDED_HD Vec3<double> point(uint32_t vertex) const { return convert<double>(positions[vertex]); }
};

}  // namespace collided
