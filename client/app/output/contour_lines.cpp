// Contours as lines between the points of a file of contacts.

#include "client/app/output/contour_lines.hpp"

#include "client/app/output/located.hpp"

namespace collided::cli {

ContourLines::ContourLines(const client::FrameOutput& output, const StepPositions& positions) {
  for_each_located(output, positions, [&](const LocatedContact&) { ++contact_count; });
  const client::Contacts& crossings = output.edge_triangle;
  if (positions.scene == nullptr || crossings.count == 0) return;
  contours = client::join_crossings(crossings, *positions.scene, positions.end);
  const size_t first_crossing = contact_count - crossings.count;  // they are the last kind
  for (const client::Contour& contour : contours) {
    std::vector<size_t>& line = points.emplace_back();
    for (const client::Contour::Point& point : contour.points) {
      const bool is_corner = point.crossing == client::kNoCrossing;
      line.push_back(is_corner ? contact_count + corners.size() : first_crossing + point.crossing);
      if (is_corner) corners.push_back(point.position);
    }
    if (contour.is_closed) line.push_back(line.front());
  }
}

size_t ContourLines::segment_count() const {
  size_t count = 0;
  for (const std::vector<size_t>& line : points) count += line.size() - 1;
  return count;
}

}  // namespace collided::cli
