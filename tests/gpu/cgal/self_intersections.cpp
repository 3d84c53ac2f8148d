#include "tests/gpu/cgal/self_intersections.hpp"

#ifdef COLLIDED_HAVE_CGAL

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <stdexcept>

namespace collided::test {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

Mesh mesh_of(const Positions& positions, const std::vector<std::array<uint32_t, 3>>& triangles) {
  Mesh mesh;
  for (const Vec3d& p : positions) mesh.add_vertex({p[0], p[1], p[2]});
  for (const auto& [a, b, c] : triangles)
    if (mesh.add_face(Mesh::Vertex_index(a), Mesh::Vertex_index(b), Mesh::Vertex_index(c)) == Mesh::null_face())
      throw std::runtime_error("triangle " + std::to_string(mesh.number_of_faces()) + " makes the surface no manifold");
  return mesh;
}

}  // namespace

bool has_cgal() { return true; }

SelfIntersections self_intersections(const Positions& positions,
                                     const std::vector<std::array<uint32_t, 3>>& triangles) {
  const Mesh mesh = mesh_of(positions, triangles);
  std::vector<std::pair<Mesh::Face_index, Mesh::Face_index>> found;
  CGAL::Polygon_mesh_processing::self_intersections(mesh, std::back_inserter(found));
  SelfIntersections out;
  for (const auto& [f, g] : found) {
    if (f == g)
      out.no_area.push_back(f);
    else
      out.pairs.push_back(key_of(std::min<uint32_t>(f, g), std::max<uint32_t>(f, g)));
  }
  std::ranges::sort(out.pairs);
  std::ranges::sort(out.no_area);
  return out;
}

}  // namespace collided::test

#else

namespace collided::test {

bool has_cgal() { return false; }
SelfIntersections self_intersections(const Positions&, const std::vector<std::array<uint32_t, 3>>&) { return {}; }

}  // namespace collided::test

#endif
