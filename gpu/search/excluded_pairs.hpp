#pragma once
// Pairs of features of one mesh that are never contacts: those that few edges connect, and those that were close when
// the scene began. A scene without such pairs has none of these tables, and its searches have no look-ups.

#include "gpu/base/key_set.hpp"
#include "gpu/base/keys.hpp"
#include "gpu/boxes/boxes.hpp"
#include "gpu/search/elementary_numbers.hpp"

namespace collided {

/// For each vertex the others that at most k edges lead to, k being that of its mesh.
struct VertexRings {
  Span<const uint32_t> begin;  ///< of each vertex's; one more at the end; empty: no mesh has rings
  // Of a world, where there are several: both vertices are of the same one.
  Span<const uint32_t> vertices;  ///< ascending for each vertex

  COLLIDED_HD bool is_needed() const { return !begin.empty(); }
  /// Whether w is in the ring of v, and so v in that of w.
  COLLIDED_HD bool connect(uint32_t v, uint32_t w) const {
    const uint32_t first_of_world = v / of_world() * of_world();
    v -= first_of_world, w -= first_of_world;
    uint32_t first = begin[v];
    const uint32_t end = begin[v + 1];
    for (uint32_t count = end - first; count > 0;) {
      const uint32_t half = count / 2;
      const bool is_before = vertices[first + half] < w;
      first += is_before ? half + 1 : 0;
      count = is_before ? count - half - 1 : half;
    }
    return first < end && vertices[first] == w;
  }
  COLLIDED_HD uint32_t size(uint32_t v) const {
    const uint32_t of_first = v % of_world();
    return begin[of_first + 1] - begin[of_first];
  }
  /// Calls use(w) for each w in the ring of v.
  template <class Use>
  COLLIDED_HD void for_each(uint32_t v, const Use& use) const {
    const uint32_t of_first = v % of_world(), first_of_world = v - of_first;
    for (uint32_t i = begin[of_first]; i < begin[of_first + 1]; ++i) use(first_of_world + vertices[i]);
  }
  COLLIDED_HD bool connect(uint32_t v, const Triangle& t) const {
    return connect(v, t.x) || connect(v, t.y) || connect(v, t.z);
  }
  COLLIDED_HD bool connect(const Triangle& s, const Triangle& t) const {
    return connect(s.x, t) || connect(s.y, t) || connect(s.z, t);
  }

 private:
  COLLIDED_HD uint32_t of_world() const { return static_cast<uint32_t>(begin.size()) - 1; }
};

/// The key of a pair of edges in the set that vertex-triangle pairs are in as well. Edges have 31 bits.
COLLIDED_HD inline uint64_t rest_key_of_edges(uint32_t edge, uint32_t other) {
  return pack_ids(min(edge, other), max(edge, other)) | uint64_t{1} << 63;
}
COLLIDED_HD inline uint64_t rest_key_of_vertex(uint32_t vertex, uint32_t triangle) {
  return pack_ids(vertex, triangle);
}

/// Tests have the numbers of search/elementary_numbers.hpp; `tests` knows the features of triangles
/// (search/elementary.hpp).
struct ExcludedPairs {
  VertexRings rings;
  KeySet rest;

  COLLIDED_HD bool is_needed() const { return rings.is_needed() || !rest.empty(); }

  template <class Tests>
  COLLIDED_HD bool has_vertex_triangle(const Tests& tests, uint32_t a, uint32_t b, int test) const {
    const uint32_t triangle = test < 3 ? b : a;
    const uint32_t vertex = of_corner(tests.vertices_of(test < 3 ? a : b), test < 3 ? test : test - 3);
    if (rings.is_needed() && rings.connect(vertex, tests.vertices_of(triangle))) return true;
    return rest.has(rest_key_of_vertex(vertex, triangle));
  }
  template <class Tests>
  COLLIDED_HD bool has_edge_edge(const Tests& tests, uint32_t a, uint32_t b, int test) const {
    const int k = first_edge_of(test), m = second_edge_of(test);
    if (rings.is_needed() && are_edges_connected(tests.vertices_of(a), k, tests.vertices_of(b), m)) return true;
    if (rest.empty()) return false;
    return rest.has(rest_key_of_edges(of_corner(tests.edges_of(a), k), of_corner(tests.edges_of(b), m)));
  }

 private:
  COLLIDED_HD static uint32_t of_corner(const Triangle& t, int k) { return k == 0 ? t.x : k == 1 ? t.y : t.z; }
  COLLIDED_HD bool are_edges_connected(const Triangle& p, int k, const Triangle& q, int m) const {
    const uint32_t a = of_corner(p, k), b = of_corner(p, k == 2 ? 0 : k + 1);
    const uint32_t c = of_corner(q, m), d = of_corner(q, m == 2 ? 0 : m + 1);
    return rings.connect(a, c) || rings.connect(a, d) || rings.connect(b, c) || rings.connect(b, d);
  }
};

/// For scenes without such pairs: no look-up at all.
struct NothingExcluded {
  COLLIDED_HD static constexpr bool is_needed() { return false; }
  template <class Tests>
  COLLIDED_HD bool has_vertex_triangle(const Tests&, uint32_t, uint32_t, int) const {
    return false;
  }
  template <class Tests>
  COLLIDED_HD bool has_edge_edge(const Tests&, uint32_t, uint32_t, int) const {
    return false;
  }
};

}  // namespace collided
