#include <cmath>

#include "tests/support/families/query_families.hpp"
#include "tests/support/families/query_families_degenerate.hpp"

namespace collided::test {
namespace {

Query anything(QueryKind kind, Scalar, Random& random) {
  Query query{kind, {}};
  for (Vec3d& p : query.p) p = random.vector(1);
  return query;
}

Query aimed_query(QueryKind kind, Scalar, Random& random) { return aimed(kind, random); }

// Half of them by chance, half made to touch.
Query lattice(QueryKind kind, Scalar, Random& random) {
  if (random.chance(0.5)) return play(exact_touch(kind, random, eighths(random)));
  Query query{kind, {}};
  for (Vec3d& p : query.p) p = random.lattice(3);
  return query;
}

// Integers up to 2^20 + 60: floats hold them.
Query far_lattice(QueryKind kind, Scalar scalar, Random& random) {
  const Vec3d place = times(0x1p20, random.lattice(1));
  return translated(lattice(kind, scalar, random), place);
}

// In one plane at t = 0, or throughout.
Query coplanar(QueryKind kind, Scalar, Random& random) {
  if (random.chance(0.5)) return tilted_coplanar(kind, random);
  Query query{kind, {}};
  for (size_t i = 0; i < 8; ++i) {
    query.p[i] = random.chance(0.5) ? random.lattice(3) : random.vector(1);
    if (i < 4) query.p[i][2] = 0;
  }
  return turned(query, random);
}

// Each feature keeps its shape; they touch exactly at t = 1, or miss by 2^-k.
Query translation(QueryKind kind, Scalar, Random& random) {
  Touch touch = exact_touch(kind, random, 1);
  const size_t second = first_feature(kind);
  for (size_t i = 0; i < 4; ++i) touch.velocity[i] = touch.velocity[i < second ? 0 : second];
  Query query = play(touch);
  const double off = random.signed_power(-18, 0);
  if (random.chance(0.5))
    for (size_t i = 0; i < second; ++i) query.p[i + 4][0] += off;
  return query;
}

double mixed_power(Random& random) {
  const double power = random.signed_power(-20, 20);
  return power * (1 + random.unit());
}

// Exact contacts of integers, each axis in its own unit, up to the square roots of the type's range apart:
// products underflow beside others that do not.
Query mixed_axes(QueryKind kind, Scalar scalar, Random& random) {
  const int range = scalar == Scalar::kF32 ? 60 : 500;
  Touch touch = exact_touch(kind, random, eighths(random));
  part_sometimes(touch, random);
  Query query = play(touch);
  for (size_t axis = 0; axis < 3; ++axis) {
    const double unit = random.signed_power(-range, range);
    for (Vec3d& p : query.p) p[axis] *= unit;
  }
  return query;
}

// Coordinates and velocities from 2^-20 to 2^20 within one query.
Query mixed_powers(QueryKind kind, Scalar scalar, Random& random) {
  if (random.chance(0.25)) return mixed_axes(kind, scalar, random);
  Touch touch{kind, {}, {}, random.unit()};
  for (size_t i = 0; i < 4; ++i) {
    for (double& x : touch.at[i]) x = mixed_power(random);
    for (double& x : touch.velocity[i]) x = mixed_power(random);
  }
  const Weights weights = random_weights(kind, random);
  if (random.chance(0.7)) bring_together(touch, weights, random_gap(random, 1, 40));
  return play(touch);
}

Query degenerate(QueryKind kind, Scalar, Random& random) {
  switch (random.integer(0, 2)) {
    case 0:
      return needle(kind, random, std::ldexp(1.0, -random.integer(1, 50)));
    case 1:
      return zero_area(kind, random);
    default:
      return duplicate_vertices(kind, random);
  }
}

}  // namespace

const std::vector<QueryFamily>& fuzz_families() {
  static const std::vector<QueryFamily> families{
      {"anything", anything},         {"aimed", aimed_query}, {"lattice", lattice},
      {"far lattice", far_lattice},   {"coplanar", coplanar}, {"translation", translation},
      {"mixed powers", mixed_powers}, {"denormal", denormal}, {"degenerate", degenerate},
  };
  return families;
}

}  // namespace collided::test
