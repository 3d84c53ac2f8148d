#pragma once
// Judges what is told of solids, in integers and by brute force over all triangles. It shares no code with the engine:
// - winding numbers by rays in a direction that meets no edge, which is tried;
// - depths by the nearest of all triangles' borders and faces;
// - volumes in common by the theorem of separating axes, of convex bodies that the scene names;
// - signs of distances by the closest points themselves.

#include <memory>

#include "tests/gpu/solid_shapes.hpp"

namespace collided::test {

/// Convex bodies that together are where a surface's winding number is 1 or more, and those that a part of it which is
/// inside out takes away.
struct Pieces {
  std::vector<Shape> within, inside_out = {};
};
struct Body {
  Shape surface;
  Pieces pieces;
};

/// A case, and of each mesh the pieces of its body; none of a mesh that is no solid.
struct SolidsScene {
  Case c;
  std::vector<Pieces> pieces;
  std::vector<std::array<uint32_t, 2>> excluded;
};

struct JudgedInside {
  uint32_t vertex, mesh;
  long double depth;              ///< in the unit of the positions, within 2^-62 of its size
  std::vector<uint32_t> nearest;  ///< triangles at that distance, ascending
};
struct JudgedPair {
  uint32_t first, second;
  PairState state;
  uint32_t first_inside, second_inside;
  /// They touch, or overlap without a vertex inside, and a part that is inside out has a volume in common with the
  /// other mesh: either may be said.
  bool is_open;
};
struct JudgedSolids {
  std::vector<JudgedInside> inside;  ///< by vertex, then mesh
  std::vector<JudgedPair> pairs;     ///< that are not apart, by first, then second
  uint64_t on = 0;                   ///< pairs of a vertex and a solid that it is on
  uint64_t inside_out = 0;           ///< pairs whose winding number is below 0
  uint64_t deep = 0;                 ///< pairs whose winding number is 2 or more
  uint64_t apart = 0;                ///< pairs of meshes whose boxes meet
};

/// What decides the sign of a contact's distance.
struct JudgedSign {
  std::array<uint32_t, 2> meshes;    ///< of the features
  bool has_solid;                    ///< the features are of two meshes, one of them a solid
  bool meets;                        ///< the triangle or an edge has a point in common with the other mesh
  int sign;                          ///< -1 if one of the closest points is inside the other mesh, else 1
  std::array<long double, 3> apart;  ///< from the second feature's closest point to the first one's
};

class SolidsJudge {
 public:
  virtual ~SolidsJudge() = default;
  virtual JudgedSolids judge() const = 0;
  /// The distance of a vertex from a triangle, as JudgedInside has it.
  virtual long double distance(uint32_t vertex, uint32_t triangle) const = 0;
  /// Ids are those of a contact.
  virtual JudgedSign of_vertex_triangle(const std::array<uint32_t, 2>& ids) const = 0;
  virtual JudgedSign of_edge_edge(const std::array<uint32_t, 2>& ids) const = 0;
};

/// The scene's positions are those of its case at the end, rounded to the scalar type already.
std::unique_ptr<SolidsJudge> make_solids_judge(const SolidsScene& scene);

}  // namespace collided::test
