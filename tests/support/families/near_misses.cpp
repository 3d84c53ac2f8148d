#include "tests/support/families/near_misses.hpp"

#include <cmath>

#include "tests/support/families/query_families_shapes.hpp"

namespace collided::test {
namespace {

double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3d unit(const Vec3d& a) { return times(1 / std::sqrt(dot(a, a)), a); }
Vec3d without(const Vec3d& a, const Vec3d& along) { return plus(a, times(-dot(a, along), along)); }

/// 10^low to 10^high, all exponents alike.
double power_of_ten(Random& random, double low, double high) { return std::pow(10.0, random.within(low, high)); }

Vec3d in_plane(Random& random) {
  Vec3d v = random.vector(1);
  v[2] = 0;
  return v;
}

bool is_planar(NearMissFamily family) {
  return family == NearMissFamily::kCoplanar || family == NearMissFamily::kNearPlanar;
}

/// Inside a side, at a corner, or close to it.
double along_side(Random& random) {
  if (random.chance(0.5)) return random.within(0.1, 0.9);
  return random.chance(0.5) ? 0 : power_of_ten(random, -12, -1);
}

/// Four points with the first feature `gap` away from the second, in direction `away`, which is across the motion.
struct Passing {
  Points at;
  Vec3d away;
};

Passing vertex_in_plane(double gap, Random& random) {
  Points p{Vec3d{}, in_plane(random), in_plane(random), in_plane(random)};
  const Vec3d side = minus(p[2], p[1]);
  // A sliver now and then.
  if (random.chance(0.1)) {
    const double share = random.within(-1, 2);
    p[3] = plus(plus(p[1], times(share, side)), times(power_of_ten(random, -10, -1), in_plane(random)));
  }
  const Vec3d other = minus(p[3], p[1]);
  Vec3d out = unit({side[1], -side[0], 0}), out_of_other = unit({other[1], -other[0], 0});
  if (dot(out, other) > 0) out = times(-1, out);
  if (dot(out_of_other, side) > 0) out_of_other = times(-1, out_of_other);
  const double place = along_side(random), turn = random.unit();
  if (place == 0) out = unit(plus(out, times(turn, out_of_other)));
  p[0] = plus(plus(p[1], times(place, side)), times(gap, out));
  return {p, out};
}

Passing edges_in_plane(double gap, Random& random) {
  Points p{Vec3d{}, Vec3d{}, in_plane(random), in_plane(random)};
  const Vec3d side = minus(p[3], p[2]);
  Vec3d out = unit({side[1], -side[0], 0});
  const double place = along_side(random), turn = random.unit();
  if (place == 0) out = unit(plus(out, times(-turn, unit(side))));
  p[0] = plus(plus(p[2], times(place, side)), times(gap, out));
  Vec3d edge = in_plane(random);
  if (dot(edge, out) < 0) edge = times(-1, edge);
  // Parallel to the side, or almost.
  if (random.chance(0.3)) edge = without(edge, out);
  if (random.chance(0.1)) edge = plus(edge, times(power_of_ten(random, -12, -1), out));
  p[1] = plus(p[0], edge);
  return {p, out};
}

/// Returns a corner in the plane z = 0, or below it.
Vec3d below(NearMissFamily family, Random& random) {
  Vec3d v = in_plane(random);
  if (family == NearMissFamily::kSliding && random.chance(0.6))
    v[2] = random.chance(0.5) ? -random.unit() : -power_of_ten(random, -12, -1);
  return v;
}

Passing vertex_above(NearMissFamily family, double gap, Random& random) {
  const Vec3d up{0, 0, 1};
  Points p{Vec3d{}, in_plane(random), below(family, random), below(family, random)};
  Vec3d at = p[1];
  if (p[2][2] == 0) at = plus(at, times(along_side(random), minus(p[2], p[1])));
  if (p[2][2] == 0 && p[3][2] == 0 && random.chance(0.5)) at = plus(at, times(along_side(random), minus(p[3], at)));
  p[0] = plus(at, times(gap, up));
  return {p, up};
}

Passing edge_above(NearMissFamily family, double gap, Random& random) {
  const Vec3d up{0, 0, 1};
  Points p{Vec3d{}, Vec3d{}, in_plane(random), below(family, random)};
  Vec3d at = p[2];
  if (p[3][2] == 0) at = plus(at, times(along_side(random), minus(p[3], p[2])));
  const Vec3d edge = times(-1, below(family, random));
  p[0] = plus(at, times(gap, up));
  if (edge[2] == 0 && random.chance(0.5)) p[0] = plus(p[0], times(-random.unit(), edge));
  p[1] = plus(p[0], edge);
  return {p, up};
}

Passing passing(NearMissFamily family, QueryKind kind, double gap, Random& random) {
  const bool vertex = kind == QueryKind::kVertexTriangle;
  if (is_planar(family)) return vertex ? vertex_in_plane(gap, random) : edges_in_plane(gap, random);
  return vertex ? vertex_above(family, gap, random) : edge_above(family, gap, random);
}

/// Most often across `away`. In one plane, every point goes its own way in half of the cases.
Points velocities(NearMissFamily family, QueryKind kind, const Passing& passing, Random& random) {
  const auto any = [&] { return is_planar(family) ? in_plane(random) : random.vector(1); };
  Vec3d way = times(power_of_ten(random, -3, 0.5), any());
  if (random.chance(0.8)) way = without(way, passing.away);
  Points velocity{};
  if (!is_planar(family) || random.chance(0.5)) {
    for (size_t k = 0; k < first_feature(kind); ++k) velocity[k] = way;
    return velocity;
  }
  for (Vec3d& v : velocity) v = times(power_of_ten(random, -3, 0.3), any());
  velocity[0] = plus(velocity[first_feature(kind)], way);
  return velocity;
}

/// Rotated, as it is, or sheared by a dyadic matrix, which keeps planes exactly.
Query placed(Query query, Random& random) {
  const int frame = random.integer(0, 2);
  if (frame == 0) {
    const Vec3d x = unit(random.vector(1)), y = unit(cross(x, random.vector(1))), z = cross(x, y);
    for (Vec3d& p : query.p) p = plus(plus(times(p[0], x), times(p[1], y)), times(p[2], z));
  }
  const auto on_grid = [](double x) { return std::ldexp(std::round(std::ldexp(x, 45)), -45); };
  if (frame == 2)
    for (Vec3d& p : query.p) {
      for (double& x : p) x = on_grid(x);
      p[2] = on_grid(p[2] + p[0] + p[1] / 2);
    }
  return query;
}

}  // namespace

std::string name_of(NearMissFamily family) {
  switch (family) {
    case NearMissFamily::kCoplanar:
      return "Coplanar";
    case NearMissFamily::kNearPlanar:
      return "NearPlanar";
    case NearMissFamily::kSliding:
      return "Sliding";
    default:
      return "Gliding";
  }
}

Query near_miss(NearMissFamily family, QueryKind kind, double thickness, Random& random) {
  double gap = power_of_ten(random, -16, -5);
  if (thickness > 0 && random.chance(0.3)) gap = -gap;
  const Passing pass = passing(family, kind, thickness + gap, random);
  Query query = play({kind, pass.at, velocities(family, kind, pass, random), random.unit()});
  const double off = family == NearMissFamily::kNearPlanar ? power_of_ten(random, -17, -3) : 0;
  const Vec3d moved = random.chance(0.5) ? in_plane(random) : Vec3d{};
  for (size_t k = 0; k < 8; ++k) {
    query.p[k][2] += off * random.within(-1, 1);
    if (k >= 4) query.p[k] = plus(query.p[k], moved);
  }
  return placed(query, random);
}

}  // namespace collided::test
