#pragma once
// The vertices of contacts on the host.

#include <array>
#include <cstdint>

#include "gpu/types.hpp"

namespace collided {

/// Four scene-wide vertex ids: a vertex and its triangle's, or those of both edges.
using ContactVertices = std::array<uint32_t, 4>;

/// Finds the vertices of a contact by its two features.
using FindVertices = ContactVertices (*)(const std::array<uint32_t, 2>& elements, const Topology& topology);

namespace detail {
inline ContactVertices find_vertex_triangle(const std::array<uint32_t, 2>& elements, const Topology& topology) {
  const auto& triangle = topology.triangles[elements[1]];
  return {elements[0], triangle[0], triangle[1], triangle[2]};
}
inline ContactVertices find_edge_edge(const std::array<uint32_t, 2>& elements, const Topology& topology) {
  const auto &a = topology.edges[elements[0]], &b = topology.edges[elements[1]];
  return {a[0], a[1], b[0], b[1]};
}
inline constexpr PerKind<FindVertices> kFindVertices{.vertex_triangle = find_vertex_triangle,
                                                     .edge_edge = find_edge_edge,
                                                     .triangle_triangle = nullptr,
                                                     .edge_triangle = nullptr,
                                                     .vertex_solid = find_vertex_triangle};
}  // namespace detail

/// Returns null for a kind whose contacts have no stencils.
constexpr FindVertices stencil_finder(ContactKind kind) { return value_of(detail::kFindVertices, kind); }

}  // namespace collided
