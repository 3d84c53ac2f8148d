#pragma once
// Queries of the narrow phase from the bytes of an input.

#include <cmath>

#include "tests/fuzz/targets/fuzz.hpp"
#include "tests/support/judge/exact_judge.hpp"

namespace collided::fuzz {

/// How an input spells coordinates: in few bytes where much coincides, or as they are.
enum class Coordinates : uint8_t { kLattice, kPowers, kDoubles };

inline double finite(double x) { return std::isfinite(x) ? x : 0; }

inline double coordinate(Input& input, Coordinates how) {
  switch (how) {
    case Coordinates::kLattice:
      return input.number<int8_t>();
    case Coordinates::kPowers: {
      const auto mantissa = input.number<int16_t>();
      return std::ldexp(mantissa, input.number<int8_t>() / 4);
    }
    case Coordinates::kDoubles:
      break;
  }
  return finite(input.number<double>());
}

template <class Points>
void read_points(Input& input, Coordinates how, Points& points) {
  for (auto& point : points)
    for (double& x : point) x = coordinate(input, how);
}

/// The first byte has the kind, the way of spelling and, in its high bits, what the target makes of it.
struct Head {
  test::QueryKind kind;
  Coordinates how;
  uint8_t rest;

  explicit Head(uint8_t byte)
      : kind(byte & 1 ? test::QueryKind::kEdgeEdge : test::QueryKind::kVertexTriangle),
        how(static_cast<Coordinates>((byte >> 1 & 3) % 3)),
        rest(byte >> 3) {}
};

}  // namespace collided::fuzz
