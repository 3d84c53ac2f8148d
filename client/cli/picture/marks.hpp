#pragma once
// Marks of a picture: contacts of vertices with triangles, contacts of edges, and lines along which triangles cross.

#include <cstdint>
#include <vector>

#include "client/app/output/contact_points.hpp"
#include "client/scenes/vec3.hpp"

namespace collided::cli {

/// Two edges that touch: where, and which ways they go (of any length).
struct EdgeMark {
  scenes::Vec3d point, first, second;
};

/// In the scene's coordinates.
struct Marks {
  std::vector<scenes::Vec3d> vertices;                  ///< vertex-triangle contacts
  std::vector<EdgeMark> edges;                          ///< edge-edge contacts
  std::vector<std::array<scenes::Vec3d, 2>> crossings;  ///< along which triangles cross; ends may be the same
  std::vector<uint32_t> touched, crossed;               ///< elements of the first and of the last
  bool is_empty() const { return vertices.empty() && edges.empty() && crossings.empty(); }
};

/// Adds contacts of vertices with triangles and of edges.
void mark_contacts(Marks& marks, const client::FrameOutput& output, const StepPositions& positions);
/// Adds the triangle-triangle contacts of a frame without motion, whose positions these are.
void mark_triangle_pairs(Marks& marks, const client::Contacts& pairs, const client::SceneFeatures& scene,
                         client::Positions positions);
/// Adds the contours of the edge-triangle contacts of a frame without motion, whose positions these are. A contour of
/// one point is a line without length.
void mark_contours(Marks& marks, const client::Contacts& crossings, const client::SceneFeatures& scene,
                   client::Positions positions);

/// The segment that two triangles have in common, to rounding; its ends may be the same.
std::array<scenes::Vec3d, 2> crossing_of(const std::array<scenes::Vec3d, 3>& a, const std::array<scenes::Vec3d, 3>& b);

}  // namespace collided::cli
