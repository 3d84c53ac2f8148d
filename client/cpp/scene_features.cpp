// The features of a scene by the ids that contacts name them with.

#include "client/cpp/scene_features.hpp"

#include <algorithm>
#include <functional>
#include <string>
#include <tuple>

namespace collided::client {

namespace {

constexpr int kDataLoss = 15;

size_t mesh_of(const char* what, uint32_t id, const std::vector<uint64_t>& ends) {
  checked_id(what, id, ends.empty() ? 0 : ends.back());
  return static_cast<size_t>(std::upper_bound(ends.begin(), ends.end(), uint64_t{id}) - ends.begin());
}

/// A side of an element.
struct Side {
  SceneFeatures::Edge edge;
  uint32_t element;
  bool operator<(const Side& o) const { return std::tie(edge, element) < std::tie(o.edge, o.element); }
};

}  // namespace

uint32_t checked_id(const char* what, uint32_t id, size_t count) {
  if (id < count) return id;
  throw Error(kDataLoss, std::string("the daemon's contacts name ") + what + " " + std::to_string(id) +
                             "; the scene has " + std::to_string(count));
}

SceneFeatures::SceneFeatures(std::span<const MeshInput> meshes) {
  for (const MeshInput& mesh : meshes) {
    const size_t first = elements_.size();
    elements_.insert(elements_.end(), mesh.triangles.begin(), mesh.triangles.end());
    for (const auto& [a, b] : mesh.edges) elements_.push_back({a, b, b});
    for (const uint32_t a : mesh.points) elements_.push_back({a, a, a});
    add_mesh(mesh.vertex_count, first);
  }
  number_edges();
}

SceneFeatures::SceneFeatures(std::span<const MeshElements> meshes) {
  for (const MeshElements& mesh : meshes) {
    const size_t first = elements_.size();
    elements_.insert(elements_.end(), mesh.elements.begin(), mesh.elements.end());
    add_mesh(mesh.vertex_count, first);
  }
  number_edges();
}

/// Turns the vertices of the elements from `first_element` on from the mesh's into the scene's.
void SceneFeatures::add_mesh(uint32_t vertex_count, size_t first_element) {
  const uint64_t base = end_of(vertex_ends_);
  for (size_t i = first_element; i < elements_.size(); ++i)
    for (uint32_t& vertex : elements_[i]) vertex += static_cast<uint32_t>(base);
  vertex_ends_.push_back(base + vertex_count);
  element_ends_.push_back(elements_.size());
}

void SceneFeatures::number_edges() {
  std::vector<Side> sides;
  sides.reserve(3 * elements_.size());
  for (uint32_t id = 0; id < elements_.size(); ++id) {
    const Element& element = elements_[id];
    for (size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(element[k], element[(k + 1) % 3]);
      if (low != high) sides.push_back({{low, high}, id});
    }
  }
  std::ranges::sort(sides, std::less<>());
  for (const Side& side : sides) {
    const bool is_new = edges_.empty() || edges_.back() != side.edge;
    if (is_new) edges_.push_back(side.edge), triangle_ends_.push_back(triangles_.size());
    const Element& element = elements_[side.element];
    if (element[1] != element[2]) triangles_.push_back(side.element), triangle_ends_.back() = triangles_.size();
  }
  for (const uint64_t end : vertex_ends_)  // edges are in the order of their vertices, and so of meshes
    edge_ends_.push_back(static_cast<uint64_t>(
        std::ranges::lower_bound(edges_, end, {}, [](const Edge& edge) { return edge[0]; }) - edges_.begin()));
}

std::span<const uint32_t> SceneFeatures::triangles_of(uint32_t edge) const {
  checked_id("edge", edge, edges_.size());
  const uint64_t begin = edge == 0 ? 0 : triangle_ends_[edge - 1];
  return std::span(triangles_).subspan(begin, triangle_ends_[edge] - begin);
}

size_t SceneFeatures::mesh_of_vertex(uint32_t id) const { return mesh_of("vertex", id, vertex_ends_); }
size_t SceneFeatures::mesh_of_edge(uint32_t id) const { return mesh_of("edge", id, edge_ends_); }
size_t SceneFeatures::mesh_of_element(uint32_t id) const { return mesh_of("element", id, element_ends_); }

}  // namespace collided::client
