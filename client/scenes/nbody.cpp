// Scene nbody: 240 spheres of different sizes on a shrinking, jittering lattice among five fixed cones.

#include "client/scenes/families.hpp"
#include "client/scenes/math.hpp"

namespace collided::scenes {

namespace {

constexpr uint32_t kSpheres = 240, kCones = 5;
constexpr uint32_t kLattice[3] = {8, 6, 5};

Vec3d centre_of(uint32_t n, double t) {
  const uint32_t cell[3] = {n % 8, n / 8 % 6, n / 48};
  const double spacing = 1.35 - 0.5 * smooth(0, 1, t);
  Vec3d out;
  for (uint32_t a = 0; a < 3; ++a) {
    const double cycles = 1 + hash01(n, 5 + a);
    const double jitter = 0.25 * std::sin(2 * kPi * (cycles * t + hash01(n, 2 + a)));
    out[a] = (cell[a] - (kLattice[a] - 1) / 2.0) * spacing + jitter;
  }
  return out;
}

/// All spheres share a grid: the first parameter is the angle plus 8 times the sphere's number.
Vec3d spheres(Param at, double t) {
  const auto n = static_cast<uint32_t>(at[0] / 8);
  const double angle = at[0] - 8.0 * n, r = 0.16 * std::pow(3.2, hash01(n, 1));
  const Vec3d c = centre_of(n, t), d = polar(r * std::sin(at[1]), angle, r * std::cos(at[1]));
  return {c[0] + d[0], c[1] + d[1], c[2] + d[2]};
}

Vec3d cones(Param at, double) {
  const auto n = static_cast<uint32_t>(at[0] / 8);
  const Vec3d d = polar(0.55 * (1 - 0.95 * at[1]), at[0] - 8.0 * n, 1.6 * at[1] - 3.4);
  return {d[0] + 2.2 * (n - 2.0), d[1] + 1.1 * ((n % 2) - 0.5), d[2]};
}

/// Copies of a grid: copy n adds 8 n (more than a turn, and exact in binary) to the first parameter.
Part copies(const Part& one, uint32_t count) {
  Part all = one;
  for (uint32_t n = 1; n < count; ++n) {
    Part next = one;
    for (Param& p : next.params) p[0] += 8.0 * n;
    append(all, next);
  }
  return all;
}

}  // namespace

ScenePtr make_nbody(double scale) {
  std::vector<Part> parts{
      copies(uv_sphere("spheres", refine(20, scale, 3), refine(16, scale, 3)), kSpheres),
      copies(grid("cones", {0, 2 * kPi, refine(40, scale, 3)}, {0, 1, refine(5, scale)}, true), kCones)};
  parts[0].formula = spheres;
  parts[1].formula = cones;
  parts[1].mesh.is_static = true;
  return std::make_unique<FormulaScene>(std::move(parts));
}

}  // namespace collided::scenes
