#pragma once
// Scenes of tests/gpu/narrow/step_scenes.hpp for a detector.

#include <cmath>

#include "tests/gpu/narrow/step_scenes.hpp"
#include "tests/support/case.hpp"

namespace collided::test {

inline constexpr AdvanceMode kModes[] = {AdvanceMode::kAllOrOne, AdvanceMode::kPerMesh, AdvanceMode::kPerVertex};

/// The scene on its way from x to p.
inline Case case_of(const StepScene& scene, const std::vector<Vec3d>& x, const std::vector<Vec3d>& p) {
  Case c;
  uint32_t first = 0;
  for (uint32_t mesh = 0; mesh < scene.is_static.size(); ++mesh) {
    uint32_t end = first;
    while (end < scene.mesh.size() && scene.mesh[end] == mesh) ++end;
    std::vector<std::array<uint32_t, 3>> triangles;
    std::vector<std::array<uint32_t, 2>> edges;
    std::vector<uint32_t> points;
    for (const auto& t : scene.triangles) {
      if (t[0] < first || t[0] >= end) continue;
      const uint32_t a = t[0] - first, b = t[1] - first, d = t[2] - first;
      if (b != d)
        triangles.push_back({a, b, d});
      else if (a != b)
        edges.push_back({a, b});
      else
        points.push_back(a);
    }
    const auto of_mesh = [&](const std::vector<Vec3d>& all) {
      return Positions(all.begin() + first, all.begin() + end);
    };
    add_mesh(c, std::move(triangles), of_mesh(x), of_mesh(p), scene.is_static[mesh]);
    c.meshes.back().edges = std::move(edges), c.meshes.back().points = std::move(points);
    first = end;
  }
  return c;
}

/// Touching, too near, resting or apart.
inline StepScene placed_scene(uint64_t seed, double least_exponent) {
  Random random(seed);
  const double gaps[] = {0, 0.5e-3, 1e-3, std::pow(10.0, random.within(least_exponent, -2))};
  StepScene scene = any_scene(static_cast<int>(seed % 4), gaps[random.integer(0, 3)]);
  const Turn turn(random.vector(3));
  const double offset = random.chance(0.5) ? 0 : 4;
  for (Vec3d& p : scene.positions) p = plus(turn(p), {offset, 0.7 * offset, 0.3 * offset});
  return scene;
}

}  // namespace collided::test
