#pragma once
// What a picture marks: contacts of vertices with triangles, of edges, and triangles that cross.

#include <cstdint>
#include <span>
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
  std::vector<std::array<scenes::Vec3d, 2>> crossings;  ///< along which triangles cross
  std::vector<uint32_t> touched, crossed;               ///< elements of the first and of the last
  bool is_empty() const { return vertices.empty() && edges.empty() && crossings.empty(); }
};

/// An element: a triangle, a loose edge a b b or a loose point a a a, with vertices of the whole scene.
using Element = std::array<uint32_t, 3>;

/// Adds contacts that have points.
void mark_contacts(Marks& marks, const client::FrameOutput& output, const StepPositions& positions);
/// Adds the triangle-triangle contacts of a frame without motion, whose positions these are.
void mark_crossings(Marks& marks, const client::Contacts& pairs, std::span<const Element> elements,
                    client::Positions positions);

/// The segment that two triangles have in common, to rounding; its ends may be the same.
std::array<scenes::Vec3d, 2> crossing_of(const std::array<scenes::Vec3d, 3>& a, const std::array<scenes::Vec3d, 3>& b);

}  // namespace collided::cli
