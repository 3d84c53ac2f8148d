#pragma once
// Meshes of the example.

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

struct Vec {
  double x = 0, y = 0, z = 0;
};
inline Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(double s, const Vec& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(const Vec& a) { return std::sqrt(dot(a, a)); }

struct Mesh {
  std::vector<Vec> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
};

inline Mesh make_floor() { return {{{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}}, {{0, 1, 2}, {0, 2, 3}}}; }

inline Mesh make_sphere(double radius, double height, uint32_t meridians, uint32_t parallels) {
  Mesh mesh;
  const auto add = [&](double down, double around) {
    const double r = radius * std::sin(down);
    mesh.vertices.push_back({r * std::cos(around), r * std::sin(around), height + radius * std::cos(down)});
  };
  const uint32_t north = meridians * (parallels - 1), south = north + 1;
  const auto at = [&](uint32_t i, uint32_t j) {
    return i == 0 ? north : i == parallels ? south : (i - 1) * meridians + j % meridians;
  };
  for (uint32_t i = 1; i < parallels; ++i)
    for (uint32_t j = 0; j < meridians; ++j)
      add(std::numbers::pi * i / parallels, 2 * std::numbers::pi * j / meridians);
  add(0, 0);
  add(std::numbers::pi, 0);
  for (uint32_t i = 0; i < parallels; ++i)
    for (uint32_t j = 0; j < meridians; ++j) {
      if (i > 0) mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < parallels) mesh.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  return mesh;
}

/// Not quite flat, so that nothing is balanced on an edge; diagonals alternate, so that no direction is stiffer.
inline Mesh make_sheet(double side, double height, uint32_t cells) {
  Mesh mesh;
  const uint32_t row = cells + 1;
  for (uint32_t i = 0; i < row; ++i)
    for (uint32_t j = 0; j < row; ++j) {
      const double x = side * (1.0 * j / cells - 0.5), y = side * (1.0 * i / cells - 0.5);
      mesh.vertices.push_back({x, y, height + 0.002 * std::sin(9 * x + 5 * y)});
      if (i == cells || j == cells) continue;
      const uint32_t a = i * row + j, b = a + 1, c = a + row, d = c + 1;
      const bool even = (i + j) % 2 == 0;
      mesh.triangles.push_back({a, b, even ? d : c});
      mesh.triangles.push_back({even ? a : b, d, c});
    }
  return mesh;
}
