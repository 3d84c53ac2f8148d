#pragma once
// Pairs of features whose boxes overlap, found without the engine: sort and sweep on one axis, exact comparisons.

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "tests/support/case.hpp"

namespace collided::test {

using PairKey = uint64_t;  ///< first id << 32 | second id: ascending keys are the canonical order

inline PairKey key_of(uint32_t first, uint32_t second) { return static_cast<PairKey>(first) << 32 | second; }

/// A box inflated with outward rounding may catch pairs a hair further apart than the thickness,
/// so the pairs that must be found and those that may be found are two sets. With thickness 0 they are the same.
struct PairSet {
  std::vector<PairKey> must;  ///< gap <= thickness, decided exactly; sorted
  std::vector<PairKey> may;   ///< gap <= thickness * (1 + 1e-5) + a few ulp; sorted, includes `must`
};

struct ExpectedPairs {
  PairSet vertex_triangle;
  PairSet edge_edge;
};

enum class ElementKind : uint8_t { kTriangle, kEdge, kPoint };

/// Scene-wide ids as in collided::Topology, computed independently.
struct Features {
  std::vector<uint32_t> mesh_of_vertex;
  std::vector<std::array<uint32_t, 3>> triangles;  ///< of all elements: a loose edge is (a, b, b), a point (a, a, a)
  std::vector<ElementKind> kinds;                  ///< of each of them
  std::vector<std::array<uint32_t, 2>> edges;
};
Features features_of(const Case& c);

/// Vertex-triangle pairs by what the meshes declare: a vertex of any element and a triangle; a lone point, which is in
/// no triangle and no edge, and a loose edge, which is in no triangle; and two lone points, once, the second by its
/// element, the first by a lower one. Of loose elements that are declared again the first counts.
class VertexTrianglePairs {
 public:
  explicit VertexTrianglePairs(const Features& features);
  /// Whether the two are tested if their boxes overlap and their meshes may touch.
  bool has(uint32_t vertex, uint32_t element) const;
  bool is_used(uint32_t vertex) const { return used_.contains(vertex); }

 private:
  const Features& features_;
  std::set<uint32_t> used_;
  std::map<uint32_t, uint32_t> lone_points_;  ///< and the element of each
  std::set<uint32_t> lone_edges_;             ///< by their elements
};

/// Pairs of the case (already rounded to `scalar`). DCD looks at t = 1 only, CCD at the boxes swept from t = 0 to 1.
ExpectedPairs brute_force(const Case& c, Mode mode, Scalar scalar, double thickness);

/// What is wrong with the engine's list, or empty: order, repeats, misses, extra pairs.
std::string compare(std::span<const std::array<uint32_t, 2>> found, const PairSet& expected);

}  // namespace collided::test
