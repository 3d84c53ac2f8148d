#pragma once
// Exact decisions of a frame: one pair of features, or of triangles, at a time.

#include <array>

#include "gpu/exact/exact.hpp"

namespace collided {

struct ExactQuestion {
  ContactKind kind = ContactKind::kVertexTriangle;  ///< as for exact_ccd
  bool continuous = true;                           ///< else the positions at t = 1 alone count
  ContactDistance limit = {};
};

/// v a b c or a0 a1 b0 b1: at t = 0, then at t = 1.
using ExactPoints = std::array<Vec3<double>, 8>;
/// Three corners of each triangle.
using ExactTriangles = std::array<Vec3<double>, 6>;

struct ExactAnswer {
  bool hit = false;
  double toi = 0;        ///< as ExactImpact::toi; 0 if not continuous
  bool initial = false;  ///< in contact at t = 0
};

ExactAnswer decide_exactly(const ExactQuestion& question, const ExactPoints& points);

/// A hit if the closed triangles have a point in common. With `has_common_corner` their first corners are one vertex,
/// and they have to meet beyond it.
ExactAnswer decide_triangles_exactly(const ExactTriangles& corners, bool has_common_corner);

}  // namespace collided
