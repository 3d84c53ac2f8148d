#include "tests/gpu/solid_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace collided::test {
namespace {

template <class Random>
std::vector<uint32_t> shuffled(size_t count, Random& random) {
  std::vector<uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::shuffle(order, random);
  return order;
}

}  // namespace

double volume6(const Positions& p) {
  double m[3][3];
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k) m[i][k] = p[i + 1][k] - p[0][k];
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

Shape box(const Vec3d& lo, const Vec3d& hi) {
  Shape box;
  for (uint32_t i = 0; i < 8; ++i)
    box.positions.push_back({i & 1 ? hi[0] : lo[0], i & 2 ? hi[1] : lo[1], i & 4 ? hi[2] : lo[2]});
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return box;
}
Shape unit_cube() { return box({0, 0, 0}, {1, 1, 1}); }

Shape tetrahedron(Positions corners) {
  if (volume6(corners) < 0) std::swap(corners[0], corners[1]);
  return {corners, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}
Shape inscribed(bool is_other) {
  Positions corners{{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
  for (Vec3d& p : corners)
    if (is_other) p = {1 - p[0], 1 - p[1], 1 - p[2]};
  return tetrahedron(corners);
}

Shape unit_ball(uint32_t bands, uint32_t sectors) {
  Shape ball{{{0, 0, 1}}, {}};
  for (uint32_t i = 1; i < bands; ++i)
    for (uint32_t j = 0; j < sectors; ++j) {
      const double down = std::numbers::pi * i / bands, around = 2 * std::numbers::pi * j / sectors;
      ball.positions.push_back({std::sin(down) * std::cos(around), std::sin(down) * std::sin(around), std::cos(down)});
    }
  ball.positions.push_back({0, 0, -1});
  const auto last = static_cast<uint32_t>(ball.positions.size() - 1);
  const auto at = [&](uint32_t i, uint32_t j) {
    return i == 0 ? 0 : i == bands ? last : 1 + (i - 1) * sectors + j % sectors;
  };
  for (uint32_t i = 0; i < bands; ++i)
    for (uint32_t j = 0; j < sectors; ++j) {
      if (i > 0) ball.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < bands) ball.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  return ball;
}

Case apart(const std::vector<Shape>& shapes) {
  Case c;
  for (const Shape& shape : shapes) {
    add_mesh(c, shape.triangles, shape.positions);
    c.meshes.back().self_contacts = false;
  }
  return c;
}
Case alone(const Shape& shape) {
  Case c;
  add_mesh(c, shape.triangles, shape.positions);
  return c;
}

std::vector<Row> pairs_of_solids() {
  const Shape second = box({-1, -1, 0}, {1, 1, 2});
  return {{"1", apart({box({-3, -1, 0}, {-1, 1, 2}), second})},
          {"2", apart({box({-3, -1, 0}, {-0.9, 1, 2}), second})},
          {"3", apart({box({-3, -1, 0}, {-1.1, 1, 2}), second})},
          {"4", apart({unit_cube(), box({.25, .25, .9}, {.75, .75, 2})})},
          {"5", apart({box({-3, -1, -1}, {3, 1, 1}), box({-1, -3, .5}, {1, 3, 3})})},
          {"6", apart({box({-3, -1, -1}, {3, 1, 1}), box({-1, -3, -1.5}, {1, 3, .5})})},
          {"7", apart({box({0, 0, 0}, {10, 10, 10}), box({4, 4, 4}, {5, 5, 5})})},
          {"8", apart({unit_cube(), unit_cube()})},
          {"9", apart({inscribed(false), inscribed(true)})},
          {"10", apart({unit_cube(), inscribed(false)})},
          {"11a", apart({unit_cube(), box({1, 1, 1}, {2, 2, 2})})},
          {"11b", apart({unit_cube(), box({1, 1, 0}, {2, 2, 1})})},
          {"12", apart({unit_ball(6, 8), box({-2, -.25, -.25}, {2, .25, .25})})}};
}

Shape reversed(Shape shape) {
  for (auto& corners : shape.triangles) std::swap(corners[1], corners[2]);
  return shape;
}

Shape together(Shape first, const Shape& second) {
  const auto begin = static_cast<uint32_t>(first.positions.size());
  first.positions.insert(first.positions.end(), second.positions.begin(), second.positions.end());
  for (const auto& t : second.triangles) first.triangles.push_back({t[0] + begin, t[1] + begin, t[2] + begin});
  return first;
}

std::vector<uint32_t> in_order(const Case& c) {
  std::vector<uint32_t> origin(std::accumulate(c.meshes.begin(), c.meshes.end(), size_t{0},
                                               [](size_t n, const MeshSpec& mesh) { return n + mesh.vertex_count; }));
  std::iota(origin.begin(), origin.end(), 0u);
  return origin;
}

std::pair<Case, std::vector<uint32_t>> renumbered(const Case& c, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<uint32_t> begin(c.meshes.size() + 1, 0);
  for (size_t m = 0; m < c.meshes.size(); ++m) begin[m + 1] = begin[m] + c.meshes[m].vertex_count;
  Case out;
  std::vector<uint32_t> origin;
  for (const uint32_t m : shuffled(c.meshes.size(), random)) {
    const std::vector<uint32_t> was = shuffled(c.meshes[m].vertex_count, random);
    std::vector<uint32_t> now(was.size());
    Positions positions;
    for (uint32_t v = 0; v < was.size(); ++v) {
      now[was[v]] = v;
      positions.push_back(c.end[m][was[v]]);
      origin.push_back(begin[m] + was[v]);
    }
    Triangles triangles;
    for (const uint32_t t : shuffled(c.meshes[m].triangles.size(), random)) {
      auto corners = c.meshes[m].triangles[t];
      for (uint32_t& v : corners) v = now[v];
      std::ranges::rotate(corners, corners.begin() + random() % 3);
      triangles.push_back(corners);
    }
    add_mesh(out, triangles, positions);
    out.meshes.back().self_contacts = c.meshes[m].self_contacts;
  }
  return {out, origin};
}

Case moved(Case c, double scale, double by) {
  for (auto* meshes : {&c.start, &c.end})
    for (Positions& mesh : *meshes)
      for (Vec3d& p : mesh)
        for (double& x : p) x = x * scale + by;
  return c;
}

}  // namespace collided::test
