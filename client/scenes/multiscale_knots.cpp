// Scene multiscale_knots: four reef knots side by side, each an eighth of the one before: no single cell size fits.

#include "client/scenes/families.hpp"

namespace collided::scenes {

ScenePtr make_multiscale_knots(double scale) {
  std::vector<Part> parts;
  double size = 1, y = 0;
  for (int knot = 0; knot < 4; ++knot) {
    for (Part& ribbon : reef_knot_ribbons("knot" + std::to_string(knot), scale, size, {0, y, 0}))
      parts.push_back(std::move(ribbon));
    y += 1.3 * size;  // beside the knot just made, so that the next one brushes it
    size /= 8;
    y += 1.3 * size;
  }
  return std::make_unique<FormulaScene>(std::move(parts));
}

}  // namespace collided::scenes
