#pragma once
// Small scenes of meshes for tests of steps.

#include <cmath>
#include <map>

#include "tests/gpu/narrow/serial_steps.hpp"

namespace collided::test {

struct Shape {
  std::vector<Vec3d> vertices;
  std::vector<std::array<uint32_t, 3>> faces;
};

/// A square of n by n vertices, of this width.
inline Shape sheet(uint32_t n, double width, const Vec3d& centre) {
  Shape shape;
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = 0; j < n; ++j)
      shape.vertices.push_back(plus(centre, {width * (i / (n - 1.0) - 0.5), width * (j / (n - 1.0) - 0.5), 0}));
  for (uint32_t i = 0; i + 1 < n; ++i)
    for (uint32_t j = 0; j + 1 < n; ++j) {
      const uint32_t a = i * n + j, b = a + n;
      shape.faces.push_back({a, b, b + 1});
      shape.faces.push_back({a, b + 1, a + 1});
    }
  return shape;
}

/// A cube with edges of this length whose lowest face's centre is `base`.
inline Shape cube(double size, const Vec3d& base) {
  Shape shape;
  for (int i = 0; i < 8; ++i)
    shape.vertices.push_back(plus(base, {size * ((i & 1) - 0.5), size * ((i >> 1 & 1) - 0.5), size * (i >> 2 & 1)}));
  shape.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return shape;
}

/// An icosahedron.
inline Shape ball(double radius, const Vec3d& centre) {
  Shape shape;
  const double g = (1 + std::sqrt(5.0)) / 2, scale = radius / std::sqrt(1 + g * g);
  for (const double a : {-1.0, 1.0})
    for (const double b : {-g, g}) {
      shape.vertices.push_back(plus(centre, times(scale, {a, b, 0})));
      shape.vertices.push_back(plus(centre, times(scale, {0, a, b})));
      shape.vertices.push_back(plus(centre, times(scale, {b, 0, a})));
    }
  const auto near = [&](uint32_t i, uint32_t j) {
    const Vec3d d = minus(shape.vertices[i], shape.vertices[j]);
    return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) < 2.1 * scale;
  };
  for (uint32_t i = 0; i < 12; ++i)
    for (uint32_t j = i + 1; j < 12; ++j)
      for (uint32_t k = j + 1; k < 12; ++k)
        if (near(i, j) && near(j, k) && near(i, k)) shape.faces.push_back({i, j, k});
  return shape;
}

/// A rotation by a vector whose length is the angle.
struct Turn {
  Vec3d axis;
  double angle;

  explicit Turn(const Vec3d& by) : axis(by), angle(std::hypot(by[0], by[1], by[2])) {
    if (angle > 0) axis = times(1 / angle, axis);
  }
  Vec3d operator()(const Vec3d& p) const {
    const double along = axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
    const Vec3d across{axis[1] * p[2] - axis[2] * p[1], axis[2] * p[0] - axis[0] * p[2],
                       axis[0] * p[1] - axis[1] * p[0]};
    return plus(plus(times(std::cos(angle), p), times(std::sin(angle), across)),
                times(along * (1 - std::cos(angle)), axis));
  }
};

template <class Real>
std::vector<Vec3d> rounded_to(std::vector<Vec3d> positions) {
  for (Vec3d& p : positions)
    for (double& x : p) x = static_cast<Real>(x);
  return positions;
}

inline constexpr FractionOf kFractionsOf[] = {FractionOf::kVertex, FractionOf::kMesh, FractionOf::kScene};

inline void add(StepScene& scene, const Shape& shape, bool fixed = false) {
  scene.add(shape.vertices, shape.faces, fixed);
}

/// Moves the vertices of a mesh.
template <class Move>
std::vector<Vec3d> moved(const StepScene& scene, std::vector<Vec3d> x, uint32_t mesh, const Move& move) {
  for (size_t v = 0; v < x.size(); ++v)
    if (scene.mesh[v] == mesh) x[v] = move(x[v]);
  return x;
}
inline std::vector<Vec3d> moved_by(const StepScene& scene, const std::vector<Vec3d>& x, uint32_t mesh,
                                   const Vec3d& by) {
  return moved(scene, x, mesh, [&](const Vec3d& p) { return plus(p, by); });
}
inline double least_height(const StepScene& scene, const std::vector<Vec3d>& x, uint32_t mesh) {
  double least = HUGE_VAL;
  for (size_t v = 0; v < x.size(); ++v)
    if (scene.mesh[v] == mesh) least = std::min(least, x[v][2]);
  return least;
}
inline double least_of(const std::vector<double>& fractions) { return *std::ranges::min_element(fractions); }

inline StepScene cube_over_floor(double gap) {
  StepScene scene;
  add(scene, sheet(4, 4, {0, 0, 0}), true);
  add(scene, cube(1, {0.13, 0.21, gap}));
  return scene;
}

/// Two sheets, a cube over a sheet that stands, two balls over one, or a tetrahedron whose corner points at a sheet.
inline StepScene any_scene(int which, double gap) {
  StepScene scene;
  const auto add = [&](const Shape& shape, bool fixed = false) { scene.add(shape.vertices, shape.faces, fixed); };
  if (which == 0) add(sheet(4, 1, {0, 0, 0})), add(sheet(4, 1, {0.11, 0.07, gap}));
  if (which == 1) add(sheet(3, 2, {0, 0, 0}), true), add(cube(1, {0, 0, gap}));
  if (which == 2) {
    const Shape below = ball(0.5, {0, 0, 0});
    double lowest = 0, highest = 0;
    for (const Vec3d& v : below.vertices) lowest = std::min(lowest, v[2]), highest = std::max(highest, v[2]);
    add(below), add(ball(0.5, {0.01, 0, highest - lowest + gap})), add(sheet(3, 2, {0, 0, lowest - gap}));
  }
  if (which == 3) {
    add(sheet(4, 1, {0, 0, 0}));
    scene.add({{0.02, 0.01, gap}, {0.3, 0, 0.2}, {0, 0.3, 0.2}, {-0.2, 0, 0.3}},
              {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
  }
  return scene;
}

/// Where a solver might want them: meshes turned and moved, vertices shaken.
template <class Real>
std::vector<Vec3d> any_target(const StepScene& scene, const std::vector<Vec3d>& x, double size, Random& random) {
  const double way = size * std::pow(10.0, random.within(-6, -0.5));
  std::vector<Vec3d> p = x;
  if (random.chance(0.5))
    for (Vec3d& v : p) v = plus(v, random.vector(way));
  for (uint32_t mesh = 0; mesh < scene.is_static.size(); ++mesh) {
    const Turn turn(times(std::pow(10.0, random.within(-8, -0.5)), random.vector(1)));
    const Vec3d by = random.vector(way);
    if (!random.chance(0.7)) continue;
    const size_t first = static_cast<size_t>(std::ranges::find(scene.mesh, mesh) - scene.mesh.begin());
    for (size_t v = 0; v < p.size(); ++v)
      if (scene.mesh[v] == mesh) p[v] = plus(plus(turn(minus(p[v], x[first])), x[first]), by);
  }
  for (size_t v = 0; v < p.size(); ++v)
    if (scene.is_static[scene.mesh[v]]) p[v] = x[v];
  return rounded_to<Real>(p);
}

}  // namespace collided::test
