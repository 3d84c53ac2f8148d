// Scene multiscale_knots: four reef knots in a row, each smaller than the previous one by a fixed ratio (8 unless the
// name says otherwise): no single cell size fits.

#include "client/scenes/families.hpp"

namespace collided::scenes {

ScenePtr make_multiscale_knots(double scale, double ratio) {
  std::vector<Part> parts;
  double size = 1, y = 0;
  for (int knot = 0; knot < 4; ++knot) {
    for (Part& ribbon : reef_knot_ribbons("knot" + std::to_string(knot), scale, size, {0, y, 0}))
      parts.push_back(std::move(ribbon));
    y += 1.3 * size;  // next to this knot, so that the following one brushes it
    size /= ratio;
    y += 1.3 * size;
  }
  return std::make_unique<FormulaScene>(std::move(parts));
}

}  // namespace collided::scenes
