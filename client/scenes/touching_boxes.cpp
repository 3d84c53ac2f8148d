// Scene touching_boxes: a lattice of unit cubes that share whole faces exactly, so that equality decides box tests.

#include "client/scenes/families.hpp"
#include "client/scenes/math.hpp"

namespace collided::scenes {

ScenePtr make_touching_boxes(double scale) {
  const uint32_t n = refine(12, std::cbrt(scale * scale), 2);
  Part boxes;
  boxes.mesh.name = "boxes";
  for (uint32_t box = 0; box < n * n * n; ++box) {
    for (uint32_t corner = 0; corner < 8; ++corner) boxes.params.push_back({double(box), double(corner)});
    for (const auto& t : kBoxTriangles)
      boxes.mesh.triangles.push_back({8 * box + t[0], 8 * box + t[1], 8 * box + t[2]});
  }
  // Every second layer slides along by t of a cell; faces stay in the same planes.
  boxes.formula = [n](Param at, double t) -> Vec3d {
    const auto box = static_cast<uint32_t>(at[0]), corner = static_cast<uint32_t>(at[1]);
    const uint32_t x = box % n, y = box / n % n, z = box / (n * n);
    return {double(x + (corner & 1)) + (z % 2 ? t : 0), double(y + (corner >> 1 & 1)), double(z + (corner >> 2))};
  };
  std::vector<Part> parts;
  parts.push_back(std::move(boxes));
  return std::make_unique<FormulaScene>(std::move(parts));
}

}  // namespace collided::scenes
