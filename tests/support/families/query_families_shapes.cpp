#include "tests/support/families/query_families_shapes.hpp"

#include <algorithm>
#include <cmath>

namespace collided::test {
namespace {

// The two places that `weights` name.
std::array<Vec3d, 2> places(const Touch& touch, const Weights& w) {
  const Points& p = touch.at;
  if (touch.kind == QueryKind::kVertexTriangle)
    return {p[0], plus(p[1], plus(times(w[0], minus(p[2], p[1])), times(w[1], minus(p[3], p[1]))))};
  return {plus(p[0], times(w[0], minus(p[1], p[0]))), plus(p[2], times(w[1], minus(p[3], p[2])))};
}

void move_to_boundary(QueryKind kind, Random& random, Weights& w) {
  const int side = random.integer(0, 2);
  if (kind == QueryKind::kVertexTriangle && side == 2)
    w[1] = 1 - w[0];
  else
    w[static_cast<size_t>(side % 2)] = random.integer(0, 1);
}

}  // namespace

uint64_t Random::next() {
  uint64_t z = state_ += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

double Random::unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
double Random::within(double low, double high) { return low + (high - low) * unit(); }

int Random::integer(int low, int high) {
  return low + static_cast<int>(next() % static_cast<uint64_t>(high - low + 1));
}

Vec3d Random::vector(double size) {
  Vec3d v;
  for (double& x : v) x = within(-size, size);
  return v;
}

Vec3d Random::lattice(int size) {
  Vec3d v;
  for (double& x : v) x = integer(-size, size);
  return v;
}

double Random::signed_power(int low, int high) {
  const double sign = chance(0.5) ? 1 : -1;
  return sign * std::ldexp(1.0, integer(low, high));
}

Vec3d plus(const Vec3d& a, const Vec3d& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec3d minus(const Vec3d& a, const Vec3d& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec3d times(double s, const Vec3d& a) { return {s * a[0], s * a[1], s * a[2]}; }

Query play(const Touch& touch) {
  Query query{touch.kind, {}};
  for (size_t i = 0; i < 4; ++i) {
    query.p[i] = minus(touch.at[i], times(touch.time, touch.velocity[i]));
    query.p[i + 4] = plus(touch.at[i], times(1 - touch.time, touch.velocity[i]));
  }
  return query;
}

Touch random_touch(QueryKind kind, Random& random, double speed) {
  Touch touch{kind, {}, {}, random.unit()};
  for (Vec3d& p : touch.at) p = random.vector(1);
  for (Vec3d& v : touch.velocity) v = random.vector(speed);
  return touch;
}

Weights random_weights(QueryKind kind, Random& random) {
  Weights w{random.unit(), random.unit()};
  if (random.chance(1.0 / 3)) move_to_boundary(kind, random, w);
  if (kind == QueryKind::kVertexTriangle && w[0] + w[1] > 1) w = {1 - w[0], 1 - w[1]};
  return w;
}

void bring_together(Touch& touch, const Weights& weights, const Vec3d& gap) {
  const auto [first, second] = places(touch, weights);
  const Vec3d step = plus(minus(second, first), gap);
  for (size_t i = 0; i < first_feature(touch.kind); ++i) touch.at[i] = plus(touch.at[i], step);
}

Vec3d random_gap(Random& random, double size, int finest) {
  if (random.chance(0.4)) return {};
  const double length = size * std::ldexp(1.0, -random.integer(0, finest));
  return times(length, random.vector(1));
}

Query aimed(QueryKind kind, Random& random, double speed) {
  Touch touch = random_touch(kind, random, speed);
  const Weights weights = random_weights(kind, random);
  bring_together(touch, weights, random_gap(random, std::min(speed, 1.0), 60));
  return play(touch);
}

Touch exact_touch(QueryKind kind, Random& random, double time) {
  Touch touch{kind, {}, {}, time};
  for (Vec3d& p : touch.at) p = times(4, random.lattice(3));
  for (Vec3d& v : touch.velocity) v = times(8, random.lattice(2));
  Weights w{random.integer(0, 4) / 4.0, random.integer(0, 4) / 4.0};
  if (kind == QueryKind::kVertexTriangle && w[0] + w[1] > 1) w = {1 - w[0], 1 - w[1]};
  bring_together(touch, w);
  return touch;
}

void part_sometimes(Touch& touch, Random& random) {
  if (random.chance(0.75)) return;
  const Vec3d step = times(8, random.lattice(3));
  for (size_t i = 0; i < first_feature(touch.kind); ++i) touch.at[i] = plus(touch.at[i], step);
}

double eighths(Random& random) { return random.integer(0, 8) / 8.0; }

Query translated(Query query, const Vec3d& by) {
  for (Vec3d& p : query.p) p = plus(p, by);
  return query;
}

Query scaled(Query query, double by) {
  for (Vec3d& p : query.p) p = times(by, p);
  return query;
}

Query turned(Query query, Random& random) {
  std::array<size_t, 3> axis{0, 1, 2};
  for (size_t i = 2; i > 0; --i) std::swap(axis[i], axis[static_cast<size_t>(random.integer(0, static_cast<int>(i)))]);
  Vec3d sign;
  for (double& s : sign) s = random.chance(0.5) ? 1 : -1;
  for (Vec3d& p : query.p) p = {sign[0] * p[axis[0]], sign[1] * p[axis[1]], sign[2] * p[axis[2]]};
  return query;
}

}  // namespace collided::test
