#include "tests/support/families/query_families_degenerate.hpp"

#include <cmath>
#include <limits>

namespace collided::test {
namespace {

void thin(Touch& touch, size_t base, size_t tip, double width) {
  touch.at[tip] = plus(touch.at[base], times(width, minus(touch.at[tip], touch.at[base])));
  touch.velocity[tip] = touch.velocity[base];
}

double smallest(Scalar scalar) {
  return scalar == Scalar::kF32 ? static_cast<double>(std::numeric_limits<float>::denorm_min())
                                : std::numeric_limits<double>::denorm_min();
}

}  // namespace

Query needle(QueryKind kind, Random& random, double width) {
  Touch touch = random_touch(kind, random);
  thin(touch, 2, 3, width);
  if (kind == QueryKind::kEdgeEdge && random.chance(0.25)) thin(touch, 0, 1, width);
  const Weights weights = random_weights(kind, random);
  bring_together(touch, weights, random_gap(random, 1, 60));
  return play(touch);
}

Query zero_area(QueryKind kind, Random& random) {
  Touch touch = exact_touch(kind, random, eighths(random));
  const Vec3d along = kind == QueryKind::kVertexTriangle ? times(4, random.lattice(2)) : Vec3d{};
  const int third = random.integer(-1, 3);
  for (size_t i = first_feature(kind); i < 4; ++i) {
    const double place = i == 1 ? 0 : i == 2 ? 1 : third;
    touch.at[i] = plus(touch.at[first_feature(kind)], times(place, along));
    touch.velocity[i] = touch.velocity[first_feature(kind)];
  }
  if (random.chance(0.7)) bring_together(touch, {random.integer(0, 4) / 4.0, 0});
  return play(touch);
}

Query duplicate_vertices(QueryKind kind, Random& random) {
  Query query = play(exact_touch(kind, random, eighths(random)));
  const auto one = static_cast<size_t>(random.integer(0, 3)), other = (one + 1 + random.next() % 3) % 4;
  query.p[one] = query.p[other];
  if (random.chance(0.5)) query.p[one + 4] = query.p[other + 4];
  return query;
}

Query tilted_coplanar(QueryKind kind, Random& random) {
  Touch flat = exact_touch(kind, random, eighths(random));
  part_sometimes(flat, random);
  const Vec3d u = random.lattice(3), w = random.lattice(3);
  const auto into_plane = [&](Vec3d& p) { p = plus(times(p[0], u), times(p[1], w)); };
  for (Vec3d& p : flat.at) into_plane(p);
  for (Vec3d& v : flat.velocity) into_plane(v);
  return play(flat);
}

Query denormal(QueryKind kind, Scalar scalar, Random& random) {
  const double unit = smallest(scalar);
  if (random.chance(0.4)) return scaled(play(exact_touch(kind, random, eighths(random))), unit);
  if (random.chance(0.3)) {
    Query query{kind, {}};
    for (Vec3d& p : query.p) p = times(unit, random.lattice(3));
    return query;
  }
  // From coordinates of a few bits up to ordinary numbers whose products are denormal or 0.
  const int exponent = random.integer(2, 60);
  return scaled(aimed(kind, random), std::ldexp(unit, exponent));
}

}  // namespace collided::test
