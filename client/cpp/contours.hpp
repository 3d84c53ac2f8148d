#pragma once
// The lines along which meshes cross, joined from edge-triangle contacts.

#include <array>
#include <cstdint>
#include <vector>

#include "client/cpp/contacts.hpp"
#include "client/cpp/positions.hpp"
#include "client/cpp/scene_features.hpp"

namespace collided::client {

/// Stands for the end of a contour that is no crossing.
constexpr uint32_t kNoCrossing = ~0u;

/// A line along which two meshes, or a mesh and itself, cross. Between two points it lies in two triangles.
struct Contour {
  /// Where it passes from one pair of triangles to the next.
  struct Point {
    std::array<double, 3> position;  ///< in the unit of the positions
    uint32_t crossing;               ///< index among the contacts; kNoCrossing at a common corner of two neighbours
  };
  std::array<uint32_t, 2> meshes;  ///< their indices, the lower one first; both are the same of a mesh with itself
  std::vector<Point> points;       ///< one or more, those of a closed contour each once
  bool is_closed = false;          ///< a line leads from the last point to the first
};

/// Returns where crossing `i` is: (1 - w0 - w1) x_1 + w0 x_2 + w1 x_3 of its triangle. `crossings` have elements and
/// weights. Throws Error (DATA_LOSS) for ids that the scene does not have.
std::array<double, 3> crossing_point(const Contacts& crossings, size_t i, const SceneFeatures& scene,
                                     Positions positions);

/// Joins the edge-triangle contacts of a frame of DCD to contours, in the order of each one's first crossing.
///
/// A crossing of edge e and triangle T ends one segment for each triangle of e, in which that triangle and T cross. So
/// contours go on over edges of two triangles, and close on surfaces without borders. They end
///  - at an edge of one triangle, a border;
///  - at an edge of three or more, where several end;
///  - at the common corner of two triangles that cross and are neighbours, which is a point of the contour;
///  - where the other end of a segment is not among the contacts, as with `exclude_rings` of 1 or more.
/// The crossing of a loose edge is a contour of one point. A crossing is in one contour, and once, unless its edge has
/// three triangles or more.
///
/// `positions`: of all vertices of the scene. Throws Error: INVALID_ARGUMENT if the contacts have no elements or no
/// weights, or positions are not as many as vertices; DATA_LOSS for ids that the scene does not have, and if two
/// triangles have more ends of segments than two of them can have.
std::vector<Contour> join_crossings(const Contacts& crossings, const SceneFeatures& scene, Positions positions);

}  // namespace collided::client
