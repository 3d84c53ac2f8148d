#pragma once
// Scene-wide ids before and after an edit, of features of meshes that it leaves as they were.

#include <algorithm>
#include <vector>

#include "gpu/search/excluded_pairs.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Where each mesh's vertices, triangles and edges begin.
struct FeatureOffsets {
  std::vector<uint32_t> vertex, triangle, edge;  ///< one more entry at the end

  explicit FeatureOffsets(const Topology& topology)
      : vertex(topology.vertex_offset), triangle(topology.triangle_offset) {
    const auto is_before = [](const std::array<uint32_t, 2>& e, uint32_t v) { return e[0] < v; };
    for (const uint32_t first : vertex)  // edges are sorted, and connect vertices of one mesh
      edge.push_back(static_cast<uint32_t>(
          std::lower_bound(topology.edges.begin(), topology.edges.end(), first, is_before) - topology.edges.begin()));
  }
};

class IdShift {
 public:
  IdShift(const Topology& before, const Topology& after) : before_(before), after_(after) {}

  /// Of a key of ExcludedPairs::rest before: its mesh, which the edit may have changed, and the key after if it did
  /// not.
  size_t mesh_of(uint64_t key) const {
    const uint32_t first = first_id(key);
    return is_of_edges(key) ? mesh_at(before_.edge, first & ~kEdges) : mesh_at(before_.vertex, first);
  }
  uint64_t shifted(uint64_t key, size_t mesh) const {
    const uint32_t first = first_id(key), second = second_id(key);
    if (!is_of_edges(key))
      return rest_key_of_vertex(first - before_.vertex[mesh] + after_.vertex[mesh],
                                second - before_.triangle[mesh] + after_.triangle[mesh]);
    const uint32_t shift = after_.edge[mesh] - before_.edge[mesh];
    return rest_key_of_edges((first & ~kEdges) + shift, second + shift);
  }

 private:
  static constexpr uint32_t kEdges = 1u << 31;
  static bool is_of_edges(uint64_t key) { return (key >> 63) != 0; }
  /// Meshes without such features begin where the next one does.
  static size_t mesh_at(const std::vector<uint32_t>& begin, uint32_t id) {
    return static_cast<size_t>(std::upper_bound(begin.begin(), begin.end(), id) - begin.begin()) - 1;
  }

  const FeatureOffsets before_, after_;
};

}  // namespace collided
