#include "tests/support/sim/simulations.hpp"

#include <cmath>
#include <stdexcept>

#include "client/scenes/families.hpp"

namespace collided::test {
namespace {

using scenes::Part;

void add(Bodies& bodies, const Part& part, const std::function<Vec3d(scenes::Param)>& place, bool is_static = false) {
  Positions x;
  for (const scenes::Param& at : part.params) x.push_back(place(at));
  add_mesh(bodies.meshes, part.mesh.triangles, x, {}, is_static);
}
uint32_t last_mesh(const Bodies& bodies) { return static_cast<uint32_t>(bodies.meshes.meshes.size() - 1); }

void add_sheet(Bodies& bodies, uint32_t quads, double size, double height) {
  const scenes::Range side{-size / 2, size / 2, quads};
  add(bodies, scenes::grid("sheet", side, side), [&](scenes::Param at) {
    return Vec3d{at[0], at[1], height + 0.01 * std::sin(9 * at[0] + 5 * at[1])};
  });
  add_springs(bodies, last_mesh(bodies));
}
void add_ground(Bodies& bodies, double size) {
  const scenes::Range side{-size / 2, size / 2, 4};
  add(
      bodies, scenes::grid("ground", side, side),
      [](scenes::Param at) {
        return Vec3d{at[0], at[1], 0};
      },
      true);
}
/// A box of eight corners, stiff.
void add_box(Bodies& bodies, const Vec3d& centre, const Vec3d& half, double turn) {
  Positions x;
  for (int i = 0; i < 8; ++i) {
    const double dx = (i & 1 ? 1 : -1) * half[0], dy = (i & 2 ? 1 : -1) * half[1], dz = (i & 4 ? 1 : -1) * half[2];
    x.push_back({centre[0] + dx * std::cos(turn) - dy * std::sin(turn),
                 centre[1] + dx * std::sin(turn) + dy * std::cos(turn), centre[2] + dz});
  }
  add_mesh(bodies.meshes, {scenes::kBoxTriangles.begin(), scenes::kBoxTriangles.end()}, x);
  make_stiff(bodies, last_mesh(bodies));
}

Bodies cloth_on_sphere() {
  Bodies bodies;
  add(
      bodies, scenes::uv_sphere("sphere", 20, 12),
      [](scenes::Param at) {
        return Vec3d{0.3 * std::sin(at[1]) * std::cos(at[0]), 0.3 * std::sin(at[1]) * std::sin(at[0]),
                     0.3 * std::cos(at[1])};
      },
      true);
  add_sheet(bodies, 20, 1, 0.33);
  return bodies;
}

Bodies sheets() {
  Bodies bodies;
  add_ground(bodies, 3);
  for (int i = 0; i < 3; ++i) add_sheet(bodies, 10, 0.8 + 0.1 * i, 0.1 + 0.08 * i);
  return bodies;
}

Bodies soft_boxes() {
  Bodies bodies;
  bodies.gravity = {0, 0, 0};
  for (int i = 0; i < 27; ++i) {
    const Vec3d at{i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 - 1.0};
    add_box(bodies, {0.4 * at[0], 0.4 * at[1], 0.4 * at[2]}, {0.1, 0.12, 0.08}, 0.3 * i);
    bodies.velocity.insert(bodies.velocity.end(), 8,
                           {-at[0] + 0.5 * at[1], -at[1] - 0.5 * at[0] + 0.2, -at[2] + 0.3 * at[0]});
  }
  return bodies;
}

Bodies box_stack() {
  Bodies bodies;
  add_ground(bodies, 4);
  for (int i = 0; i < 20; ++i) add_box(bodies, {0, 0, 0.062 + 0.112 * i}, {0.25, 0.25, 0.05}, 0.02 * i);
  return bodies;
}

/// Two ribbons, each bent into a bight through the other's, whose ends are pulled apart.
Bodies knot() {
  Bodies bodies;
  bodies.gravity = {0, 0, 0};
  const auto scene = scenes::make_scene("reef_knot", 0.25);
  bodies.meshes = test::case_of(*scene, 0, 0);
  for (uint32_t mesh = 0; mesh < 2; ++mesh) add_springs(bodies, mesh);
  for (const Positions& ribbon : bodies.meshes.start)
    for (const Vec3d& x : ribbon) bodies.pull.push_back(std::abs(x[0]) > 8.9 ? (x[0] > 0 ? 0.6 : -0.6) : 0);
  bodies.repulsion = 0.05;
  bodies.min_separation = 0.005;
  return bodies;
}

constexpr Simulation kSimulations[] = {{"cloth_on_sphere", cloth_on_sphere},
                                       {"sheets", sheets},
                                       {"soft_boxes", soft_boxes},
                                       {"box_stack", box_stack},
                                       {"knot", knot}};

}  // namespace

std::span<const Simulation> simulations() { return kSimulations; }

const Simulation& simulation(const std::string& name) {
  for (const Simulation& s : kSimulations)
    if (s.name == name) return s;
  throw std::out_of_range("no simulation is called " + name);
}

}  // namespace collided::test
