#pragma once
// The features of a scene by the ids that contacts name them with.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "client/cpp/client.hpp"

namespace collided::client {

/// Returns `id`, that of a vertex, an edge or an element as `what` says. Throws Error (DATA_LOSS) unless it is below
/// `count`.
uint32_t checked_id(const char* what, uint32_t id, size_t count);

/// The vertices, edges and elements of a scene's meshes, by scene-wide ids as proto/CONVENTIONS.md ("Ids") gives them.
/// Edges take a sort of all sides of the scene. Functions that take an id throw as checked_id() does.
class SceneFeatures {
 public:
  using Edge = std::array<uint32_t, 2>;     ///< its vertices, the lower one first
  using Element = std::array<uint32_t, 3>;  ///< its vertices: a triangle, a loose edge a b b, or a loose point a a a

  /// The features of no meshes.
  SceneFeatures() = default;
  /// The features of a scene that is created of these meshes. Nothing is borrowed.
  explicit SceneFeatures(std::span<const MeshInput> meshes);
  /// The same of a living scene, all of whose meshes these are.
  explicit SceneFeatures(std::span<const MeshElements> meshes);

  /// The vertices of an edge.
  const Edge& edge(uint32_t id) const { return edges_[checked_id("edge", id, edges_.size())]; }
  /// The vertices of an element.
  const Element& element(uint32_t id) const { return elements_[checked_id("element", id, elements_.size())]; }
  /// The ids of the triangles that have this edge, ascending; none of a loose edge.
  std::span<const uint32_t> triangles_of(uint32_t edge) const;
  /// The number of vertices of the scene.
  size_t vertex_count() const { return end_of(vertex_ends_); }
  /// The number of elements of the scene.
  size_t element_count() const { return elements_.size(); }

  /// The index of the mesh that a vertex belongs to.
  size_t mesh_of_vertex(uint32_t id) const;
  /// The same of an edge.
  size_t mesh_of_edge(uint32_t id) const;
  /// The same of an element.
  size_t mesh_of_element(uint32_t id) const;
  /// The scene-wide id of a mesh's first vertex. `mesh` is below the number of meshes.
  uint32_t first_vertex(size_t mesh) const { return first_of(vertex_ends_, mesh); }
  /// The same of its first element.
  uint32_t first_element(size_t mesh) const { return first_of(element_ends_, mesh); }

 private:
  using Ends = std::vector<uint64_t>;  ///< of each mesh the first id behind its own

  static uint64_t end_of(const Ends& ends) { return ends.empty() ? 0 : ends.back(); }
  static uint32_t first_of(const Ends& ends, size_t mesh) {
    return mesh == 0 ? 0 : static_cast<uint32_t>(ends[mesh - 1]);
  }
  void add_mesh(uint32_t vertex_count, size_t first_element);
  void number_edges();

  std::vector<Element> elements_;
  std::vector<Edge> edges_;
  std::vector<uint32_t> triangles_;      ///< of all edges, one edge after the other
  std::vector<uint64_t> triangle_ends_;  ///< of each edge, in triangles_
  Ends vertex_ends_, edge_ends_, element_ends_;
};

}  // namespace collided::client
