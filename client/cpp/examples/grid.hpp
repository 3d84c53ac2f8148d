#pragma once
// A flat mesh for the short examples, and positions as they go on the wire.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

using Points = std::vector<std::array<double, 3>>;

inline std::span<const std::byte> bytes_of(const Points& points) { return std::as_bytes(std::span(points)); }

struct Grid {
  Points points;
  std::vector<std::array<uint32_t, 3>> triangles;
};

/// `cells` x `cells` squares of `spacing`, each of two triangles, from the origin on, at height z.
inline Grid make_grid(uint32_t cells, double spacing, double z) {
  Grid grid;
  const uint32_t row = cells + 1;
  for (uint32_t y = 0; y < row; ++y)
    for (uint32_t x = 0; x < row; ++x) {
      grid.points.push_back({x * spacing, y * spacing, z});
      if (x == cells || y == cells) continue;
      const uint32_t a = y * row + x;
      grid.triangles.insert(grid.triangles.end(), {{a, a + 1, a + row}, {a + 1, a + row + 1, a + row}});
    }
  return grid;
}
