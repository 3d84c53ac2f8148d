// Scene graded_sheets: four waving sheets whose triangles shrink with u^3 towards one edge.

#include "client/scenes/families.hpp"
#include "client/scenes/math.hpp"

namespace collided::scenes {

ScenePtr make_graded_sheets(double scale) {
  std::vector<Part> parts;
  const Range side{0, 1, refine(150, scale)};
  for (int sheet = 0; sheet < 4; ++sheet) {
    parts.push_back(grid("sheet" + std::to_string(sheet), side, side));
    parts.back().formula = [sheet](Param at, double t) -> Vec3d {
      const double x = at[0] * at[0] * at[0], y = at[1] * at[1] * at[1];
      const double lift = 0.02 * sheet * (1 - 0.8 * smooth(0, 1, t));
      return {x, y, lift + 0.008 * std::sin(9 * x + 2.1 * sheet + 3 * t) * std::cos(7 * y + 1.3 * sheet - 2 * t)};
    };
  }
  return std::make_unique<FormulaScene>(std::move(parts));
}

}  // namespace collided::scenes
