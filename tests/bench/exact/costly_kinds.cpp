#include "tests/bench/exact/costly_kinds.hpp"

#include <cmath>
#include <random>

namespace collided::test {
namespace {

std::vector<std::array<uint32_t, 3>> loose_triangles(uint32_t count) {
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 0; i < count; ++i) triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  return triangles;
}

/// Multiples of 2^-20 within 1.
double any_number(std::mt19937_64& random) { return static_cast<double>(random() >> 43) * 0x1p-20 - 1; }

/// 60 triangles anywhere, scaled about a centre along each axis.
Case scaled(const char* name, const Vec3d& centre, const Vec3d& scale) {
  constexpr uint32_t kTriangles = 60;
  std::mt19937_64 random(1);
  Positions start(3 * kTriangles), end;
  for (Vec3d& p : start)
    for (double& x : p) x = any_number(random);
  for (const Vec3d& p : start) {
    Vec3d& q = end.emplace_back();
    for (size_t axis = 0; axis < 3; ++axis) q[axis] = centre[axis] + scale[axis] * (p[axis] - centre[axis]);
  }
  Case c{name, {}, {}, {}};
  add_mesh(c, loose_triangles(kTriangles), start, end);
  return c;
}

Positions grid(uint32_t cells, const Vec3d& corner) {
  Positions positions;
  for (uint32_t i = 0; i <= cells; ++i)
    for (uint32_t j = 0; j <= cells; ++j) positions.push_back({corner[0] + i, corner[1] + j, corner[2]});
  return positions;
}

/// A grid of 98 triangles and another one over it, from one corner to another.
Case grids(const char* name, const Vec3d& from, const Vec3d& to) {
  constexpr uint32_t kCells = 7, kRow = kCells + 1;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 0; i < kCells; ++i)
    for (uint32_t j = 0; j < kCells; ++j) {
      const uint32_t a = i * kRow + j;
      triangles.push_back({a, a + kRow, a + 1});
      triangles.push_back({a + 1, a + kRow, a + kRow + 1});
    }
  Case c{name, {}, {}, {}};
  add_mesh(c, triangles, grid(kCells, {0, 0, 0}));
  add_mesh(c, triangles, grid(kCells, from), grid(kCells, to));
  return c;
}

/// Two triangles whose coordinates have any exponent up to `range`.
Case exponents(const char* name, int range) {
  std::mt19937_64 random(2);
  std::uniform_int_distribution<int> exponent(-range, range);
  Positions start(6), end(6);
  for (Positions* positions : {&start, &end})
    for (Vec3d& p : *positions)
      for (double& x : p) {
        const double mantissa = any_number(random);
        x = std::ldexp(mantissa, exponent(random));
      }
  Case c{name, {}, {}, {}};
  add_mesh(c, loose_triangles(2), start, end);
  return c;
}

}  // namespace

std::vector<CostlyKind> costly_kinds() {
  constexpr double kHalf = 0.5;
  const Vec3d over{0.25, 0.125, kHalf};
  return {
      {scaled("scaled through a point", {0, 0, 0}, {-2, -2, -2})},
      {scaled("scaled about a point, rounded", {0.1, 0.2, 0.3}, {-1.7, -1.7, -1.7})},
      {scaled("scaled through a line", {0, 0, 0}, {-2, -2, 1})},
      {grids("sliding at the thickness", over, {0.62, 0.335, kHalf}), Mode::kCcd, kHalf},
      {grids("sliding in at the thickness", over, {1, 0.875, kHalf}), Mode::kCcd, kHalf},
      {grids("down to the thickness", {0.25, 0.125, 1.25}, over), Mode::kCcd, kHalf},
      {grids("resting at the thickness", over, over), Mode::kDcd, kHalf},
      {exponents("exponents to 1000", 1000), Mode::kCcd, 0, {Scalar::kF64}},
      {exponents("exponents to 1000, thick", 1000), Mode::kCcd, 0.01, {Scalar::kF64}},
  };
}

}  // namespace collided::test
