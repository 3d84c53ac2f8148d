// Floors of pairs, tiny pairs that may move, and pairs that no fractions bring near: against rationals and integers.

#include "gpu/narrow/floors.hpp"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <cmath>

#include "gpu/narrow/hulls_apart.hpp"
#include "gpu/narrow/tiny_pairs.hpp"
#include "gpu/positions/blend.hpp"
#include "tests/support/families/query_families_shapes.hpp"

namespace collided::test {
namespace {

template <class Real>
FeaturePoints<Real> points_of(const Query& query) {
  FeaturePoints<Real> points;
  const auto real = [](const Vec3d& p) {
    return Vec3<Real>{static_cast<Real>(p[0]), static_cast<Real>(p[1]), static_cast<Real>(p[2])};
  };
  for (size_t i = 0; i < 4; ++i) points.start[i] = real(query.p[i]), points.end[i] = real(query.p[i + 4]);
  return points;
}

PairFloors floors(const FloorRules& rules, double f, double clearance, double extent, double coordinate) {
  return rules.floors_of<double>({f, extent, coordinate}, clearance);
}

TEST(Floors, HoldIsTheGreatestOfItsRowThatIsNotAbove) {
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const double m = i % 3 == 0 ? 0 : random.within(0.5, 1) * std::exp2(random.integer(-40, 40));
    const FloorRules rules{m, 1};
    const double kept = i % 3 == 0 ? random.within(0.5, 1) * std::exp2(random.integer(-60, 60))
                                   : m * random.unit() * std::exp2(random.integer(-40, 0));
    if (kept == 0) continue;
    const double hold = rules.hold_of(kept);
    ASSERT_LE(hold, kept);
    const double highest = 45.0 / 64 * m;
    if (m > 0 && kept >= highest) {
      ASSERT_EQ(hold, highest);
    } else {
      ASSERT_GT(2 * hold, kept);
      const double mantissa = m > 0 ? hold / highest : hold / (45.0 / 64);
      ASSERT_EQ(std::exp2(std::ilogb(mantissa)), mantissa);
    }
    ASSERT_EQ(rules.hold_of(hold), hold);
    ASSERT_LT(rules.hold_of(std::nextafter(hold, 0)), hold);
  }
}

TEST(Floors, FollowFromTheDistanceAndWhatIsNear) {
  const FloorRules rules{0x1p-10, 1};
  constexpr double kM = 0x1p-10, kNoise = 0x1p-45, kFar = HUGE_VAL;
  // Beyond the minimum separation, with nothing near that is closer: exactly that.
  EXPECT_EQ(floors(rules, 1, kFar, 1, 1).kept, kM);
  EXPECT_EQ(floors(rules, 1, kFar, 1, 1).end, kM);
  EXPECT_EQ(floors(rules, 1, kFar, 1, 1).way, 0.875 * kM);
  EXPECT_EQ(floors(rules, kM, kFar, 1, 1).end, kM - kNoise);
  // Nearer: what it has, or what others of its vertices have.
  EXPECT_EQ(floors(rules, 0.5 * kM, kFar, 1, 1).kept, 0.5 * kM);
  EXPECT_EQ(floors(rules, 0.5 * kM, kFar, 1, 1).end, 0.5 * kM - kNoise);
  EXPECT_EQ(floors(rules, 0.5 * kM, 0.25 * kM, 1, 1).kept, 0.25 * kM);
  // What is next to a pair that touches may come near, but not to nothing.
  EXPECT_EQ(floors(rules, 0.5 * kM, 0, 1, 1).kept, 4 * 0x1p-34);
  EXPECT_GE(floors(rules, 0.5 * kM, 0, 1, 1).end, 0x1p-34);
  // Held: by its row, and where noise exceeds everything by the way's own floor.
  const double held = 45.0 / 64 * kM;
  EXPECT_EQ(floors(rules, held, kFar, 1, 1).end, held);
  EXPECT_EQ(floors(rules, held + kNoise / 2, kFar, 1, 1).end, held);
  EXPECT_EQ(floors(rules, 0.6 * kM, kFar, 1, 0x1p40).end, 0.875 * 0.6 * kM);
  // Tiny by the pair's own extent, wherever it is.
  EXPECT_TRUE(floors(rules, 0x1p-35, kFar, 1, 1).is_tiny);
  EXPECT_FALSE(floors(rules, 0x1p-35, kFar, 0.25, 0x1p20).is_tiny);
  EXPECT_TRUE(floors(rules, 0, kFar, 1, 1).is_tiny);
  // Without a minimum separation.
  const FloorRules without{0, 1};
  EXPECT_EQ(without.reach(), 0x1p-32);
  EXPECT_EQ(floors(without, 1, kFar, 1, 1).kept, 0x1p-32);
}

TEST(Floors, StepAfterStepNoneSinksByMoreThanItsRow) {
  const FloorRules rules{0.01, 1};
  const PairFloors first = rules.floors_of<float>({0.005, 1, 1}, HUGE_VAL);
  double kept = 0.005;
  int steps = 0;
  for (; steps < 100'000; ++steps) {
    const double next = rules.floors_of<float>({kept, 1, 1}, HUGE_VAL).end;
    if (next == kept) break;
    ASSERT_LT(next, kept);
    ASSERT_GE(next, kept - first.noise * 1.0001);
    kept = next;
  }
  EXPECT_EQ(kept, 45.0 / 64 * 0.01 / 2);
  EXPECT_GT(steps, 1000);
}

mpq_class change_along(const Vec3<double>& n, const Query& query, size_t i, size_t j) {
  mpq_class sum = 0;
  const double components[] = {n.x, n.y, n.z};
  for (size_t k = 0; k < 3; ++k)
    sum += mpq_class(components[k]) * (mpq_class(query.p[i + 4][k]) - mpq_class(query.p[j + 4][k]) -
                                       mpq_class(query.p[i][k]) + mpq_class(query.p[j][k]));
  return sum;
}

bool truly_no_nearer(const Vec3<double>& n, const Query& query) {
  bool is = true;
  for (size_t i = 0; i < first_feature(query.kind); ++i)
    for (size_t j = first_feature(query.kind); j < 4; ++j) is = is && sgn(change_along(n, query, i, j)) >= 0;
  return is;
}

template <class Real>
bool told_no_nearer(const Vec3<double>& n, const Query& query) {
  return query.kind == QueryKind::kEdgeEdge ? comes_no_nearer_along<EdgeEdge>(n, points_of<Real>(query))
                                            : comes_no_nearer_along<VertexTriangle>(n, points_of<Real>(query));
}

/// Features that move by what rounding leaves, along an axis or together, and directions that may have zeros.
Query barely_moved(QueryKind kind, Random& random, Vec3<double>& n) {
  Query query{kind, {}};
  const double offset = std::exp2(random.integer(-4, 8)), step = std::exp2(random.integer(-60, -1));
  const Vec3d base = random.vector(offset), together = random.vector(0x1p-20);
  const int how = random.integer(0, 3);
  n = {random.within(-1, 1), random.within(-1, 1), random.within(-1, 1)};
  if (random.chance(0.5)) n.x = 0;
  if (random.chance(0.25)) n.y = 0;
  for (size_t i = 0; i < 4; ++i) {
    query.p[i] = plus(base, random.vector(1));
    const bool is_first = i < first_feature(kind);
    Vec3d by = how == 0 ? Vec3d{random.within(-1, 1), 0, 0} : how == 1 ? together : random.vector(step);
    if (how == 2) by = plus(by, times((is_first ? 1 : -1) * std::exp2(random.integer(-56, -40)), Vec3d{n.x, n.y, n.z}));
    query.p[i + 4] = plus(query.p[i], by);
  }
  return query;
}

TEST(TinyPairs, MoveOnlyIfTheyComeNoNearer) {
  for (const bool in_float : {false, true}) {
    Random random(in_float ? 3 : 2);
    int told = 0, truly = 0, wrong = 0;
    for (int i = 0; i < 40000; ++i) {
      Vec3<double> n;
      Query query = barely_moved(i % 2 ? QueryKind::kVertexTriangle : QueryKind::kEdgeEdge, random, n);
      if (in_float)
        for (Vec3d& p : query.p)
          for (double& x : p) x = static_cast<float>(x);
      const bool is_told = in_float ? told_no_nearer<float>(n, query) : told_no_nearer<double>(n, query);
      const bool is_truly = truly_no_nearer(n, query);
      told += is_told, truly += is_truly, wrong += is_told && !is_truly;
    }
    std::printf("%s: %d of 40000 come no nearer, %d are told so\n", in_float ? "F32" : "F64", truly, told);
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(told, truly / 2);
    EXPECT_GT(truly, 5000);
  }
}

/// Each vertex at a fraction of its own.
template <class Real>
Query gone(Query query, Random& random) {
  for (size_t i = 0; i < 4; ++i) {
    const double a = random.chance(0.3) ? random.integer(0, 1) : random.unit();
    for (size_t k = 0; k < 3; ++k)
      query.p[i + 4][k] = blend(static_cast<Real>(query.p[i][k]), static_cast<Real>(query.p[i + 4][k]), a);
  }
  return query;
}

/// Features on both sides of a plane, about `gap` apart all along, far from the origin.
Query beside_a_plane(QueryKind kind, Random& random, double gap, double offset) {
  Query query{kind, {}};
  const Vec3d base = random.vector(offset);
  const bool is_flat = random.chance(0.5);  // so that many ways come as near as the hulls
  Vec3d n = random.vector(1);
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) + 1e-3;
  n = times(1 / length, n);
  for (size_t i = 0; i < 8; ++i) {
    const bool is_first = i % 4 < first_feature(kind);
    Vec3d p = random.vector(1);
    const double along = p[0] * n[0] + p[1] * n[1] + p[2] * n[2];
    const double height = (is_first ? 1 : -1) * gap * (is_flat ? 0.5 : random.within(0.4, 1));
    p = plus(p, times(height - along, n));
    query.p[i] = plus(base, p);
  }
  return query;
}

template <class Real>
bool told_hulls_apart(const Query& query, double distance) {
  return query.kind == QueryKind::kEdgeEdge ? hulls_are_apart<EdgeEdge>(points_of<Real>(query), distance)
                                            : hulls_are_apart<VertexTriangle>(points_of<Real>(query), distance);
}

template <class Real>
void check_hulls(double offset, uint64_t seed) {
  Random random(seed);
  const double rounding = std::max(PositionNoise<Real>::kOfBlend * (offset + 2), 0x1p-17);  // what float tells apart
  int told = 0, near = 0, on_the_way = 0;
  constexpr int kCount = 600;
  for (int i = 0; i < kCount; ++i) {
    const double gap = rounding * std::exp2(random.within(1, 12));
    const QueryKind kind = i % 2 ? QueryKind::kVertexTriangle : QueryKind::kEdgeEdge;
    Query query = beside_a_plane(kind, random, gap, offset);
    for (Vec3d& p : query.p)
      for (double& x : p) x = static_cast<Real>(x);
    // The greatest distance that is told, as nearly as doubles have it.
    double distance = 0, above = gap * 2;
    if (!told_hulls_apart<Real>(query, distance)) continue;
    for (int k = 0; k < 40; ++k) {
      const double middle = (distance + above) / 2;
      (told_hulls_apart<Real>(query, middle) ? distance : above) = middle;
    }
    ++told;
    for (int k = 0; k < 8; ++k) {
      const Query way = gone<Real>(query, random);
      near += judge_proximity(kind, {way.p[4], way.p[5], way.p[6], way.p[7]}, distance);
      on_the_way += judge_ccd(way, distance).hit;
    }
  }
  std::printf("%s at %g: %d of %d parted\n", sizeof(Real) == 4 ? "F32" : "F64", offset, told, kCount);
  EXPECT_EQ(near, 0);
  EXPECT_EQ(on_the_way, 0);
  EXPECT_GT(told, kCount / 10);
}

TEST(Hulls, ThatArePartedKeepTheirDistanceWhateverTheFractions) {
  uint64_t seed = 10;
  for (const double offset : {0.0, 16.0, 1024.0, 0x1p20}) {
    check_hulls<double>(offset, ++seed);
    check_hulls<float>(offset, ++seed);
  }
}

}  // namespace
}  // namespace collided::test
