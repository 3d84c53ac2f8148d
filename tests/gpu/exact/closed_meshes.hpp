#pragma once
// Closed meshes for tests of exact volumes. Their triangles face outward.

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "gpu/base/vec3.hpp"

namespace collided::test {

using Point = Vec3<double>;
using Triangles = std::vector<std::array<uint32_t, 3>>;

struct Mesh {
  std::vector<Point> p;
  Triangles triangles;
};

inline const Triangles kTetrahedron = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
inline const Triangles kBox = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                               {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

inline Mesh box(const Point& from, const Point& to) {
  Mesh mesh{{}, kBox};
  for (int i = 0; i < 8; ++i) mesh.p.push_back({i & 1 ? to.x : from.x, i & 2 ? to.y : from.y, i & 4 ? to.z : from.z});
  return mesh;
}
inline Mesh reversed(Mesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}
inline Mesh together(Mesh a, const Mesh& b) {
  for (const auto& t : b.triangles) {
    a.triangles.push_back(t);
    for (uint32_t& v : a.triangles.back()) v += static_cast<uint32_t>(a.p.size());
  }
  a.p.insert(a.p.end(), b.p.begin(), b.p.end());
  return a;
}
template <class Change>
Mesh with_points(Mesh mesh, Change change) {
  for (Point& p : mesh.p) p = change(p);
  return mesh;
}

}  // namespace collided::test
