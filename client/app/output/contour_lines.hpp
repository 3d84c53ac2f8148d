#pragma once
// Contours as lines between the points of a file of contacts.

#include <vector>

#include "client/app/output/contact_points.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// Contours of a frame, and which of a file's points are on each. The file has a point for each contact, as
/// for_each_located() goes through them, and then one for each common corner at which a contour ends.
struct ContourLines {
  std::vector<client::Contour> contours;
  std::vector<std::vector<size_t>> points;  ///< of each contour, indices in the file; a closed one ends where it begins
  std::vector<scenes::Vec3d> corners;
  size_t contact_count = 0;  ///< points before the corners

  /// Joins the edge-triangle contacts. There are no contours if `positions` have no scene.
  ContourLines(const client::FrameOutput& output, const StepPositions& positions);

  /// The number of lines between two points.
  size_t segment_count() const;
};

}  // namespace collided::cli
