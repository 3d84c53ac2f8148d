#pragma once
// The makers of the procedural scenes, one file each; make_scene picks one by name.

#include "client/scenes/formula_scene.hpp"

namespace collided::scenes {

using ScenePtr = std::unique_ptr<Scene>;

ScenePtr make_funnel(double scale);
ScenePtr make_cloth_ball(double scale);
ScenePtr make_flamenco(double scale);
ScenePtr make_nbody(double scale);
ScenePtr make_reef_knot(double scale);
/// Each knot is `ratio` times smaller than the previous one.
ScenePtr make_multiscale_knots(double scale, double ratio);
ScenePtr make_graded_sheets(double scale);
ScenePtr make_touching_boxes(double scale);
ScenePtr make_one_cell(double scale);
ScenePtr make_huge_triangle(double scale);
ScenePtr make_anisotropic(double scale);

/// The two ribbons of a reef knot, shrunk by `size` and moved to `centre`; names end in "_a" and "_b".
std::vector<Part> reef_knot_ribbons(const std::string& name, double scale, double size, Vec3d centre);

}  // namespace collided::scenes
