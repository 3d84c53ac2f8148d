// What is drawn of a scene.

#include "client/cli/web/surface.hpp"

#include <algorithm>

namespace collided::cli {

namespace {

using Element = std::array<uint32_t, 3>;

/// Of each vertex of a mesh the kept one that is closest along the elements. Breadth first from all kept vertices at
/// once: in each round the vertices that the round before reached pass theirs on.
std::vector<uint32_t> closest_kept(const client::MeshElements& mesh, uint32_t stride) {
  std::vector<uint32_t> kept(mesh.vertex_count, kNotShown), round(mesh.vertex_count, kNotShown);
  for (uint32_t v = 0; v < mesh.vertex_count; v += stride) kept[v] = v / stride, round[v] = 0;
  bool is_done = stride == 1;
  for (uint32_t now = 1; !is_done; ++now) {
    is_done = true;
    for (const Element& element : mesh.elements)
      for (const uint32_t from : element)
        for (const uint32_t to : element) {
          if (round[from] != now - 1 || kept[to] != kNotShown) continue;
          kept[to] = kept[from];
          round[to] = now;
          is_done = false;
        }
  }
  return kept;
}

/// Adds an element of shown vertices, unless it has collapsed into less than it is.
void add(Surface& surface, const Element& element, const Element& shown) {
  if (std::find(shown.begin(), shown.end(), kNotShown) != shown.end()) return;
  const auto [a, b, c] = shown;
  if (element[0] == element[1])
    surface.points.push_back(a);
  else if (element[1] == element[2]) {
    if (a != b) surface.edges.push_back({a, b});
  } else if (a != b && b != c && c != a)
    surface.triangles.push_back(shown);
}

/// Several triangles may collapse into one.
void remove_repeated(std::vector<Element>& triangles, size_t from) {
  for (size_t i = from; i < triangles.size(); ++i)  // the same corner first, the same turn
    std::rotate(triangles[i].begin(), std::min_element(triangles[i].begin(), triangles[i].end()), triangles[i].end());
  const auto begin = triangles.begin() + static_cast<std::ptrdiff_t>(from);
  std::sort(begin, triangles.end());
  triangles.erase(std::unique(begin, triangles.end()), triangles.end());
}

}  // namespace

Surface make_surface(const std::vector<client::MeshElements>& meshes, uint32_t stride) {
  Surface surface;
  surface.vertex_stride = stride;
  surface.scene = client::SceneFeatures(meshes);
  for (const client::MeshElements& mesh : meshes) {
    const auto first = static_cast<uint32_t>(surface.shown_vertex.size());
    surface.first_vertex.push_back(surface.vertex_count);
    for (const uint32_t kept : closest_kept(mesh, stride))
      surface.shown_vertex.push_back(kept == kNotShown ? kNotShown : surface.vertex_count + kept);
    const size_t before = surface.triangles.size();
    for (const Element& element : mesh.elements) {
      Element shown;
      for (size_t i = 0; i < 3; ++i) shown[i] = surface.shown_vertex[first + element[i]];
      add(surface, element, shown);
    }
    if (stride > 1) remove_repeated(surface.triangles, before);
    surface.triangle_count.push_back(static_cast<uint32_t>(surface.triangles.size() - before));
    surface.vertex_count += (mesh.vertex_count + stride - 1) / stride;
  }
  surface.first_vertex.push_back(surface.vertex_count);
  return surface;
}

}  // namespace collided::cli
