#pragma once
// Building blocks of query families: numbers from a seed, and features that meet at a known time.

#include "tests/support/judge/exact_judge.hpp"

namespace collided::test {

/// SplitMix64: the same numbers on every machine, which the standard library's distributions do not guarantee. Nor does
/// C++ guarantee the order in which a call's arguments are evaluated: draw one number per statement, or in braces.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t next();
  double unit();                           ///< [0, 1)
  double within(double low, double high);  ///< [low, high)
  int integer(int low, int high);          ///< both included
  bool chance(double p) { return unit() < p; }
  Vec3d vector(double size);               ///< each coordinate within +-size
  Vec3d lattice(int size);                 ///< integers within +-size
  double signed_power(int low, int high);  ///< +-2^k, k from low to high

 private:
  uint64_t state_;
};

Vec3d plus(const Vec3d& a, const Vec3d& b);
Vec3d minus(const Vec3d& a, const Vec3d& b);
Vec3d times(double s, const Vec3d& a);

using Points = std::array<Vec3d, 4>;

/// How many of the four points are the first feature's.
inline size_t first_feature(QueryKind kind) { return kind == QueryKind::kVertexTriangle ? 1 : 2; }

/// Four points as they are at `time`, and how far each goes from t = 0 to 1.
struct Touch {
  QueryKind kind = QueryKind::kVertexTriangle;
  Points at{};
  Points velocity{};
  double time = 0;
};

Query play(const Touch& touch);

/// Random points and velocities, the latter within +-speed.
Touch random_touch(QueryKind kind, Random& random, double speed = 1);

/// Places on the two features: the triangle's 2nd and 3rd corner, or along each edge. Every third one is on a boundary.
using Weights = std::array<double, 2>;
Weights random_weights(QueryKind kind, Random& random);

/// Moves the first feature so that the two places meet, except for `gap`.
void bring_together(Touch& touch, const Weights& weights, const Vec3d& gap = {});

/// No gap in two of five cases, else one of length about size * 2^-k in any direction, k up to `finest`.
Vec3d random_gap(Random& random, double size, int finest);

/// Random features aimed at each other at a random time: contacts, near contacts and near misses.
Query aimed(QueryKind kind, Random& random, double speed = 1);

/// Features on a lattice of small integers that touch exactly at `time`, a multiple of 1/8: nothing is rounded, not
/// even in float.
Touch exact_touch(QueryKind kind, Random& random, double time);

/// Moves the first feature away in a quarter of the cases, by integers as large as the features.
void part_sometimes(Touch& touch, Random& random);

/// A multiple of 1/8 within [0, 1].
double eighths(Random& random);

Query translated(Query query, const Vec3d& by);
Query scaled(Query query, double by);

/// Applies one of the 48 symmetries of the cube, which change only the sign and place of numbers.
Query turned(Query query, Random& random);

}  // namespace collided::test
