// Scene anisotropic: two crossing families of slivers, each 1000 times as long as wide.

#include "client/scenes/families.hpp"
#include "client/scenes/math.hpp"

namespace collided::scenes {

namespace {

/// Parallel slivers along one axis; `cross` lays them along the other axis and makes them sink through the first
/// family.
Part slivers(std::string name, uint32_t count, bool cross) {
  Part part;
  part.mesh.name = std::move(name);
  for (uint32_t n = 0; n < count; ++n) {
    const double at = double(n) / count, wide = 1.0 / 1000;
    part.params.insert(part.params.end(), {Param{0, at}, Param{1, at}, Param{0.5, at + wide}});
    part.mesh.triangles.push_back({3 * n, 3 * n + 1, 3 * n + 2});
  }
  part.formula = [cross](Param p, double t) -> Vec3d {
    if (!cross) return {p[0], p[1], 0.01 * std::sin(40 * p[1])};
    return {p[1], p[0], 0.03 * (1 - 2 * t) + 0.01 * std::sin(30 * p[1])};
  };
  return part;
}

}  // namespace

ScenePtr make_anisotropic(double scale) {
  const uint32_t count = refine(2000, scale * scale, 1);
  return std::make_unique<FormulaScene>(
      std::vector<Part>{slivers("along", count, false), slivers("across", count, true)});
}

}  // namespace collided::scenes
