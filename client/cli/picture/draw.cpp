// Pictures of the steps of a motion.

#include "client/cli/picture/draw.hpp"

#include <algorithm>

#include "client/app/daemon/interrupt.hpp"
#include "client/app/input/mesh_input.hpp"

namespace collided::cli {

Drawing::Drawing(const PictureOptions& options, const Motion& motion)
    : options_(options), scene_(mesh_inputs(motion.meshes)), whole_(options.view) {
  for (int frame = 0; frame < motion.frames && !options.zoom_contacts; ++frame) {
    check_interrupt();
    for (const scenes::Vec3d& position : motion.positions(frame)) whole_.add(position);
  }
}

Drawn Drawing::step(const StepPositions& positions, const client::FrameOutput& output) const {
  Drawn drawn{{positions.end.begin(), positions.end.end()}, {}};
  if (options_.time != 1)
    for (size_t i = 0; i < drawn.positions.size(); ++i)
      drawn.positions[i] = scenes::between(positions.start[i], positions.end[i], options_.time);
  mark_contacts(drawn.marks, output, positions);
  mark_triangle_pairs(drawn.marks, output.triangle_triangle, scene_, drawn.positions);
  add_crossings(drawn, output.edge_triangle);
  return drawn;
}

void Drawing::add_crossings(Drawn& drawn, const client::Contacts& crossings) const {
  mark_contours(drawn.marks, crossings, scene_, drawn.positions);
}

View Drawing::view_of(const Drawn& drawn) const {
  if (!options_.zoom_contacts) return whole_.view();
  constexpr double kMargin = 0.05, kLeast = 0.03;  // of the marks' extent, of the scene's
  Framing marks(options_.view), scene(options_.view);
  for (const scenes::Vec3d& position : drawn.positions) scene.add(position);
  const View whole = scene.view();  // which refuses scenes that are too large, however near the marks are
  for (const scenes::Vec3d& point : drawn.marks.vertices) marks.add(point);
  for (const EdgeMark& edge : drawn.marks.edges) marks.add(edge.point);
  for (const auto& ends : drawn.marks.crossings)
    for (const scenes::Vec3d& point : ends) marks.add(point);
  if (marks.is_empty()) return whole;
  return marks.view(std::max(kMargin * marks.size(), kLeast * scene.size()));
}

Image Drawing::paint(const Drawn& drawn) const {
  return Painter(view_of(drawn), scene_, drawn.positions, drawn.marks).paint();
}

}  // namespace collided::cli
