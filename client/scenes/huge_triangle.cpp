// Scene huge_triangle: one triangle as large as the domain sweeps through a fine sheet and overlaps all its cells.

#include "client/scenes/families.hpp"
#include "client/scenes/math.hpp"

namespace collided::scenes {

ScenePtr make_huge_triangle(double scale) {
  const Range side{-1, 1, refine(100, scale)};
  Part sheet = grid("sheet", side, side);
  sheet.formula = [](Param at, double) -> Vec3d {
    return {at[0], at[1], 0.05 * std::sin(5 * at[0]) * std::cos(4 * at[1])};
  };
  Part huge;
  huge.mesh.name = "triangle";
  huge.mesh.triangles = {{0, 1, 2}};
  huge.params = {{-3, -2}, {3, -2}, {0, 4}};
  huge.formula = [](Param at, double t) -> Vec3d { return {at[0], at[1], 0.2 - 0.4 * t + 0.01 * at[0]}; };
  std::vector<Part> parts;
  parts.push_back(std::move(sheet));
  parts.push_back(std::move(huge));
  return std::make_unique<FormulaScene>(std::move(parts));
}

}  // namespace collided::scenes
