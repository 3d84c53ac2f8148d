#pragma once
// Splits polygons into triangles.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "client/scenes/scene.hpp"

namespace collided::scenes {

/// Larger concave faces are refused: the time to split one grows with the square of its corners.
inline constexpr size_t kMaxConcaveCorners = 10'000;

/// Splits one polygon of four or more corners into triangles of indices into `corners`. A convex polygon becomes the
/// fan of its first corner. Returns nothing if the polygon crosses itself.
std::optional<std::vector<std::array<uint32_t, 3>>> split_polygon(const std::vector<Vec3d>& corners);

}  // namespace collided::scenes
