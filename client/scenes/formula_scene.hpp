#pragma once
// A scene whose vertices are given by a formula of two parameters and time, and the shared grids.

#include <functional>

#include "client/scenes/scene.hpp"

namespace collided::scenes {

using Param = std::array<double, 2>;

/// One mesh, its vertices' parameters and the formula that places them, which must be thread-safe.
struct Part {
  Mesh mesh;
  std::vector<Param> params;
  std::function<Vec3d(Param, double t)> formula;
};

class FormulaScene : public Scene {
 public:
  explicit FormulaScene(std::vector<Part> parts);
  const std::vector<Mesh>& meshes() const override { return meshes_; }
  std::vector<Vec3d> positions(double t) const override;

 private:
  struct Rule {
    std::vector<Param> params;
    std::function<Vec3d(Param, double t)> formula;
  };
  std::vector<Mesh> meshes_;
  std::vector<Rule> rules_;
};

/// Of a box whose corner i is low or high along x, y and z by its bits 0, 1 and 2; they face outward.
inline constexpr std::array<std::array<uint32_t, 3>, 12> kBoxTriangles{{{0, 2, 1},
                                                                        {1, 2, 3},
                                                                        {4, 5, 6},
                                                                        {5, 7, 6},
                                                                        {0, 1, 4},
                                                                        {1, 5, 4},
                                                                        {2, 6, 3},
                                                                        {3, 6, 7},
                                                                        {0, 4, 2},
                                                                        {2, 4, 6},
                                                                        {1, 3, 5},
                                                                        {3, 7, 5}}};

/// A range of parameters, divided into quads.
struct Range {
  double first;
  double last;
  uint32_t quads;
};

/// u.quads x v.quads quads with alternating diagonals, two triangles each. A wrapped grid joins its last column to its
/// first.
Part grid(std::string name, Range u, Range v, bool wrap_u = false);

/// A sphere's parameters (longitude, angle from the north pole), with one vertex at each pole: 2 lon (lat - 1)
/// triangles.
Part uv_sphere(std::string name, uint32_t lon, uint32_t lat);

/// Appends the vertices and triangles of `other`, which `part`'s formula then places.
void append(Part& part, const Part& other);

/// n times `scale`, rounded, but at least `min`.
uint32_t refine(uint32_t n, double scale, uint32_t min = 1);

}  // namespace collided::scenes
