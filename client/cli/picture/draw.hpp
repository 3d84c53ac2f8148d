#pragma once
// Pictures of the steps of a motion.

#include <vector>

#include "client/app/input/motion.hpp"
#include "client/cli/picture/painter.hpp"

namespace collided::cli {

struct PictureOptions {
  ViewOptions view;
  double time = 1;             ///< of the step, at which it is drawn; without motion 1
  bool zoom_contacts = false;  ///< shows what is around the marks
};

/// What a picture shows.
struct Drawn {
  std::vector<scenes::Vec3d> positions;
  Marks marks;
};

/// All pictures are seen from the same place, unless they zoom.
class Drawing {
 public:
  /// Goes through all frames of the motion, which must outlive it, to see how large it is.
  Drawing(const PictureOptions& options, const Motion& motion);

  /// A step with its contacts. `positions` need no scene.
  Drawn step(const StepPositions& positions, const client::FrameOutput& output) const;
  /// Adds the contours of edge-triangle contacts in the drawn positions.
  void add_crossings(Drawn& drawn, const client::Contacts& crossings) const;
  Image paint(const Drawn& drawn) const;

 private:
  View view_of(const Drawn& drawn) const;

  const PictureOptions options_;
  const client::SceneFeatures scene_;
  Framing whole_;
};

}  // namespace collided::cli
