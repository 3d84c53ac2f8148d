#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/families/query_families.hpp"
#include "tests/support/families/query_families_degenerate.hpp"

namespace collided::test {
namespace {

auto far_away(double distance) {
  return [=](QueryKind kind, Scalar, Random& random) {
    const Vec3d corner = times(distance, random.lattice(1)), step = random.vector(0.1 * distance);
    return translated(aimed(kind, random), plus(corner, step));
  };
}

auto in_size(double size) {
  return [=](QueryKind kind, Scalar, Random& random) { return scaled(aimed(kind, random), size); };
}

auto in_speed(double speed) {
  return [=](QueryKind kind, Scalar, Random& random) { return aimed(kind, random, speed); };
}

// Some coordinate is as large as the frame check allows: an eighth of the largest number.
Query as_large_as_allowed(QueryKind kind, Scalar scalar, Random& random) {
  const double limit = scalar == Scalar::kF32 ? static_cast<double>(std::numeric_limits<float>::max()) / 8
                                              : std::numeric_limits<double>::max() / 8;
  Query query = aimed(kind, random);
  double largest = 0;
  for (const Vec3d& p : query.p)
    for (double x : p) largest = std::max(largest, std::abs(x));
  for (Vec3d& p : query.p)
    for (double& x : p) x = x / largest * limit;
  return query;
}

// In a plane across an axis throughout.
Query coplanar(QueryKind kind, Scalar, Random& random) {
  Touch touch = random_touch(kind, random);
  const Weights weights = random_weights(kind, random);
  bring_together(touch, weights, random_gap(random, 1, 60));
  part_sometimes(touch, random);
  Query query = play(touch);
  const double plane = random.integer(-2, 2);
  for (Vec3d& p : query.p) p[2] = plane;
  return turned(query, random);
}

Query tilted(QueryKind kind, Scalar, Random& random) { return tilted_coplanar(kind, random); }

// Both features go the same way, at speeds that may differ: their planes or lines meet once, always or never. At the
// same speed one hovers over the other, and only rounding brings them together or apart.
Query common_translation(QueryKind kind, Scalar, Random& random) {
  const bool is_exact = random.chance(0.3);
  Touch touch = is_exact ? exact_touch(kind, random, eighths(random)) : random_touch(kind, random);
  const Weights weights = random_weights(kind, random);
  if (!is_exact) bring_together(touch, weights, random_gap(random, 1, 60));
  const Vec3d way = touch.velocity[0];
  const double other = random.chance(0.5) ? 1 : random.integer(-1, 1) / 2.0;
  for (size_t i = 0; i < 4; ++i) touch.velocity[i] = i < first_feature(kind) ? way : times(other, way);
  return play(touch);
}

Query standing_still(QueryKind kind, Scalar, Random& random) {
  Touch touch = random.chance(0.5) ? exact_touch(kind, random, 0) : random_touch(kind, random);
  const Weights weights = random_weights(kind, random);
  if (random.chance(0.5)) bring_together(touch, weights, random_gap(random, 1, 60));
  touch.velocity = {};
  return play(touch);
}

// Touching exactly at a time, or missing by 2^-k.
auto touching_at(double time) {
  return [=](QueryKind kind, Scalar, Random& random) {
    Touch touch = exact_touch(kind, random, time);
    if (random.chance(0.4)) touch.at[0][0] += random.signed_power(-18, 0);
    return turned(play(touch), random);
  };
}

// A vertex goes along the x axis past a corner, or an edge's end past another edge's end, that lies on the axis or
// `off` from it; everything else of the two features is on different sides.
auto grazing(double off) {
  return [=](QueryKind kind, Scalar, Random& random) {
    const double shift = random.chance(0.5) ? off : -off, reach = random.integer(1, 4);
    const Vec3d ahead{reach, shift, 0}, way{2 * reach, 0, 0};
    const auto aside = [&](double side) {
      return Vec3d{random.within(-1, 1), side * random.within(0.25, 1), random.within(-1, 1)};
    };
    Query query{kind, {}};
    auto& p = query.p;
    p[0] = minus(ahead, way);
    p[4] = ahead;
    if (kind == QueryKind::kVertexTriangle) {
      p[1] = p[5] = {};
      p[2] = p[6] = aside(1);
      p[3] = p[7] = aside(1);
    } else {
      const Vec3d tail = aside(-1);
      p[1] = {tail[0] - reach, tail[1], tail[2]};
      p[5] = {tail[0] + reach, tail[1], tail[2]};
      p[2] = p[6] = {};
      p[3] = p[7] = aside(1);
    }
    return turned(query, random);
  };
}

Query thin_needle(QueryKind kind, Scalar, Random& random) { return needle(kind, random, 1e-8); }
Query without_area(QueryKind kind, Scalar, Random& random) { return zero_area(kind, random); }
Query duplicates(QueryKind kind, Scalar, Random& random) { return duplicate_vertices(kind, random); }

// Edges, or a vertex's path and a triangle, whose directions differ by `angle`.
auto parallel(double angle) {
  return [=](QueryKind kind, Scalar, Random& random) {
    Touch touch = random_touch(kind, random);
    const Points p = touch.at;
    const Vec3d tilt = random.vector(angle);
    if (kind == QueryKind::kEdgeEdge) {
      touch.at[3] = plus(p[2], plus(times(random.within(-2, 2), minus(p[1], p[0])), tilt));
    } else {
      for (size_t i = 2; i < 4; ++i) touch.velocity[i] = touch.velocity[1];
      touch.velocity[0] = plus(touch.velocity[1], plus(minus(p[2], p[1]), tilt));
    }
    const Weights weights = random_weights(kind, random);
    bring_together(touch, weights, random_gap(random, std::max(angle, 0x1p-20), 40));
    return play(touch);
  };
}

// Integers, so that nothing rounds the directions apart.
Query exactly_parallel(QueryKind kind, Scalar, Random& random) {
  Touch touch = exact_touch(kind, random, eighths(random));
  const Vec3d way = times(8, random.lattice(2));
  const size_t second = first_feature(kind);
  if (kind == QueryKind::kEdgeEdge) {
    touch.at[1] = plus(touch.at[0], way);
    touch.at[3] = plus(touch.at[2], times(random.integer(-4, 4) / 4.0, way));
    if (random.chance(0.7)) bring_together(touch, {random.integer(0, 4) / 4.0, random.integer(0, 4) / 4.0});
  } else {
    touch.velocity[0] = plus(touch.velocity[1], times(random.integer(-2, 2), minus(touch.at[2], touch.at[3])));
  }
  part_sometimes(touch, random);
  for (size_t i = 0; i < 4; ++i) touch.velocity[i] = touch.velocity[i < second ? 0 : second];
  return play(touch);
}

// One feature is 1e9 times as large as the other, and as fast for its size.
Query mixed_scale(QueryKind kind, Scalar, Random& random) {
  Touch touch = random_touch(kind, random);
  const bool swapped = random.chance(0.5);
  for (size_t i = 0; i < 4; ++i) {
    const double size = (i < first_feature(kind)) == swapped ? 1e3 : 1e-6;
    touch.at[i] = times(size, touch.at[i]);
    touch.velocity[i] = times(size, touch.velocity[i]);
  }
  const Weights weights = random_weights(kind, random);
  bring_together(touch, weights, random_gap(random, 1e-6, 40));
  return play(touch);
}

}  // namespace

const std::vector<QueryFamily>& extreme_families() {
  static const std::vector<QueryFamily> families{
      {"translate 1e3", far_away(1e3)},
      {"translate 1e6", far_away(1e6)},
      {"translate 1e8", far_away(1e8)},
      {"scale 1e-8", in_size(1e-8)},
      {"scale 1e-15", in_size(1e-15)},
      {"scale 1e8", in_size(1e8)},
      {"scale 1e30", in_size(1e30)},
      {"scale 1e-100", in_size(1e-100), true},
      {"scale 1e100", in_size(1e100), true},
      {"scale 1e300", in_size(1e300), true},
      {"as large as allowed", as_large_as_allowed},
      {"velocity 1e6", in_speed(1e6)},
      {"velocity 1e-6", in_speed(1e-6)},
      {"coplanar", coplanar},
      {"tilted coplanar", tilted},
      {"common translation", common_translation},
      {"static", standing_still},
      {"contact at t = 0", touching_at(0)},
      {"contact at t = 1", touching_at(1)},
      {"grazing at vertex", grazing(0)},
      {"grazing 2^-40 off", grazing(0x1p-40)},
      {"needle 1e-8", thin_needle},
      {"zero area", without_area},
      {"duplicate vertices", duplicates},
      {"nearly parallel 1e-9", parallel(1e-9)},
      {"exactly parallel", exactly_parallel},
      {"mixed scale 1e-6, 1e3", mixed_scale},
      {"denormals", denormal},
  };
  return families;
}

}  // namespace collided::test
