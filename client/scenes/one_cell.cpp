// Scene one_cell: four distant triangles stretch the domain to a thousand times the width of a swarm, which falls into
// one cell of a uniform grid.

#include "client/scenes/families.hpp"
#include "client/scenes/math.hpp"

namespace collided::scenes {

namespace {

Vec3d random_point(uint64_t n, uint64_t stream) {
  return {hash01(n, stream) - 0.5, hash01(n, stream + 1) - 0.5, hash01(n, stream + 2) - 0.5};
}

/// Corner `at[1]` of triangle `at[0]`: a random centre that drifts, and a random offset.
Vec3d swarm(Param at, double t) {
  const auto n = static_cast<uint64_t>(at[0]), corner = static_cast<uint64_t>(at[1]);
  const Vec3d c = random_point(n, 10), v = random_point(n, 20), d = random_point(n, 30 + 3 * corner);
  Vec3d out;
  for (int a = 0; a < 3; ++a) out[a] = 1e-3 * (c[a] + 0.3 * t * v[a] + 0.15 * d[a]);
  return out;
}

Vec3d far_away(Param at, double) {
  const auto n = static_cast<uint32_t>(at[0]), corner = static_cast<uint32_t>(at[1]);
  const double x = n & 1 ? 1 : -1, y = n & 2 ? 1 : -1, z = n == 0 || n == 3 ? 1 : -1;
  return {x + 0.01 * (corner == 1), y + 0.01 * (corner == 2), z};
}

Part loose_triangles(std::string name, uint32_t count) {
  Part part;
  part.mesh.name = std::move(name);
  for (uint32_t n = 0; n < count; ++n) {
    for (int corner = 0; corner < 3; ++corner) part.params.push_back({double(n), double(corner)});
    part.mesh.triangles.push_back({3 * n, 3 * n + 1, 3 * n + 2});
  }
  return part;
}

}  // namespace

ScenePtr make_one_cell(double scale) {
  std::vector<Part> parts{loose_triangles("swarm", refine(4000, scale * scale, 2)), loose_triangles("far", 4)};
  parts[0].formula = swarm;
  parts[1].formula = far_away;
  parts[1].mesh.is_static = true;
  return std::make_unique<FormulaScene>(std::move(parts));
}

}  // namespace collided::scenes
