#include <array>
#include <cmath>

#include "tests/support/families/query_families.hpp"
#include "tests/support/families/query_families_degenerate.hpp"

namespace collided::test {
namespace {

/// Points within 1 of the origin, which end at `scale` times their distance from a centre along each axis.
auto scaled_about(const Vec3d& centre, const Vec3d& scale) {
  return [=](QueryKind kind, Scalar scalar, Random& random) {
    Query query{kind, {}};
    for (size_t i = 0; i < 4; ++i) query.p[i] = random.vector(1);
    query = rounded(query, scalar);
    for (size_t i = 0; i < 4; ++i)
      for (size_t axis = 0; axis < 3; ++axis)
        query.p[i + 4][axis] = centre[axis] + scale[axis] * (query.p[i][axis] - centre[axis]);
    return query;
  };
}

/// Features in planes half a unit apart, which move within their planes, come down on each other, or turn upside down.
Query half_apart(QueryKind kind, Scalar, Random& random) {
  Query query{kind, {}};
  const int end = random.integer(0, 3);
  const double end_height = end < 2 ? 0.5 : end == 2 ? 1.5 : -0.5;
  const double start_height = random.chance(0.75) ? 0.5 : 2;
  for (size_t i = 0; i < 8; ++i) {
    const bool is_first = i % 4 < first_feature(kind);
    query.p[i] = times(0.125, random.lattice(8));
    query.p[i][2] = !is_first ? 0 : i < 4 ? start_height : end_height;
  }
  return turned(query, random);
}

Query exponents_far_apart(QueryKind kind, Scalar scalar, Random& random) {
  const int range = scalar == Scalar::kF32 ? 120 : 1000;
  Query query{kind, {}};
  for (Vec3d& p : query.p)
    for (double& x : p) {
      const double mantissa = random.within(-1, 1);
      x = std::ldexp(mantissa, random.integer(-range, range));
    }
  return query;
}

/// Small integers along each axis, times powers of two of its own: degenerate in many ways, at any exponents.
Query stretched_lattice(QueryKind kind, Scalar scalar, Random& random) {
  const int range = scalar == Scalar::kF32 ? 60 : 700;
  Query query{kind, {}};
  const std::array<int, 3> exponents{random.integer(-range, range), random.integer(-range, range),
                                     random.integer(-range, range)};
  for (Vec3d& p : query.p) {
    p = random.lattice(2);
    for (size_t axis = 0; axis < 3; ++axis) p[axis] = std::ldexp(p[axis], exponents[axis]);
  }
  for (size_t i = 0; i < 4; ++i)
    if (random.chance(0.2)) query.p[i + 4] = query.p[i];
  return query;
}

/// Small integers times one of three powers of two: exponents far apart, and terms that cancel each other.
Query few_exponents(QueryKind kind, Scalar scalar, Random& random) {
  const int range = scalar == Scalar::kF32 ? 60 : 700;
  const std::array<int, 3> exponents{-2, random.integer(-range, range), random.integer(-range, range)};
  Query query{kind, {}};
  for (Vec3d& p : query.p) {
    p = random.lattice(2);
    for (double& x : p) x = std::ldexp(x, exponents[static_cast<size_t>(random.integer(0, 2))]);
  }
  return query;
}

}  // namespace

const std::vector<QueryFamily>& costly_families() {
  static const std::vector<QueryFamily> families{
      {"scaled through a point", scaled_about({0, 0, 0}, {-2, -2, -2})},
      {"scaled and rounded", scaled_about({0.1, 0.2, 0.3}, {-1.7, -1.7, -1.7})},
      {"scaled through a line", scaled_about({0, 0, 0}, {-2, -2, 1})},
      {"half apart", half_apart},
      {"exponents far apart", exponents_far_apart},
      {"stretched lattice", stretched_lattice},
      {"few exponents", few_exponents},
  };
  return families;
}

}  // namespace collided::test
