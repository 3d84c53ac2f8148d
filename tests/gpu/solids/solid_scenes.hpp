#pragma once
// Random bodies on small lattices, most pairs of which touch, and scenes of many of them.

#include <random>

#include "tests/gpu/solids/solids_judge.hpp"

namespace collided::test {

class RandomBodies {
 public:
  explicit RandomBodies(uint32_t seed) : random_(seed) {}

  /// A tetrahedron, octahedron or box within [0, size]^3.
  Body convex(int size);
  /// Unit cells of a lattice, at random: bodies with steps, holes and cavities, some of which meet themselves in edges.
  Body cells(int size);
  /// Two boxes as one mesh: their parts overlap, are apart, or the second is inside out.
  Body two_boxes(int size, bool is_inside_out);
  Body tetrahedron(int size);
  Body any(int size);

  /// No solid: up to three triangles, or a loose edge, or both, or two loose points. One vertex is no element's.
  MeshSpec loose(int size, Positions& positions);

  int below(int end) { return std::uniform_int_distribution<int>(0, end - 1)(random_); }
  double real() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  /// The same body, its vertices, triangles and their first corners in another order, perhaps with a vertex that is in
  /// no triangle.
  Body shuffled(Body body);

 private:
  Vec3d point(int size);
  /// Of lower and upper corners that differ in each direction.
  std::array<Vec3d, 2> corners(int size);

  std::mt19937 random_;
};

/// Every coordinate x becomes scale * (x + by) in that direction.
Body moved(Body body, const Vec3d& by, double scale = 1);

/// Adds a mesh that is tested with all others.
void add_solid(SolidsScene& scene, const Body& body);
void add_surface(SolidsScene& scene, const MeshSpec& mesh, const Positions& positions);

}  // namespace collided::test
