// Certified distances are never above the true ones, and below them by no more than the header states. Integer
// arithmetic decides.

#include "gpu/narrow/certified_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "tests/support/families/query_families_shapes.hpp"
#include "tests/support/verdicts/verdict_score_question.hpp"

namespace collided::test {
namespace {

constexpr double kUnit = 0x1p-53;
constexpr int kStatedLoss = 20;  ///< in kUnit of the extent and the distance together

/// 10^k, k anywhere between two numbers.
double power_of_ten(Random& r, double low, double high) { return std::pow(10.0, r.within(low, high)); }
double zero_or(Random& r, double x) { return r.chance(0.5) ? x : 0; }

struct Family {
  std::string name;
  QueryKind kind;
  Points (*make)(Random&);
};

/// Ill-conditioned features. h is the scale of their distance, e that of what makes them so.
const std::vector<Family>& families() {
  constexpr QueryKind kVt = QueryKind::kVertexTriangle, kEe = QueryKind::kEdgeEdge;
  static const std::vector<Family> all = {
      {"above a face", kVt,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2);
         return Points{Vec3d{r.within(0, 0.5), r.within(0, 0.5), h}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
       }},
      {"above a sliver", kVt,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2), e = power_of_ten(r, -12, -1);
         return Points{Vec3d{0.4, 0.3 * e, h}, {0, 0, 0}, {1, 0, 0}, {0.5, e, 0}};
       }},
      {"beside an edge", kVt,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2);
         const double height = r.chance(0.5) ? h * r.unit() : zero_or(r, h);
         return Points{Vec3d{r.unit(), -h * (r.unit() + 1e-3), height}, {0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}};
       }},
      {"barely beside an edge", kVt,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2), e = power_of_ten(r, -18, -10);
         return Points{Vec3d{r.unit(), -e, h}, {0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}};
       }},
      {"beside a corner", kVt,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2);
         const double across = -h * (r.unit() + 1e-2), back = -h * r.unit();
         return Points{Vec3d{across, back, zero_or(r, h)}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
       }},
      {"at the corner of a sliver", kVt,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2), e = power_of_ten(r, -10, -1);
         const double height = zero_or(r, h);
         return Points{Vec3d{0.5, -h, height}, {0.5, 0, 0}, {0, e, 0}, {1, e * r.unit(), 0}};
       }},
      {"edges across", kEe,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2);
         return Points{Vec3d{-1, 0, 0}, {r.within(0.1, 1), 0, 0}, {0, -1, h}, {0, r.within(0.1, 1), h}};
       }},
      {"nearly parallel edges", kEe,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2), e = power_of_ten(r, -15, -1);
         return Points{Vec3d{-1, 0, 0}, {1, 0, 0}, {-1, -e, h}, {1, e, h}};
       }},
      {"parallel edges", kEe,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2);
         return Points{Vec3d{-1, 0, 0}, {1, 0, 0}, {-0.7, 0, h}, {1.3, 0, h}};
       }},
      {"an edge that barely reaches the other", kEe,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2), e = power_of_ten(r, -18, -8);
         return Points{Vec3d{-1, 0, 0}, {r.chance(0.5) ? e : -e, 0, 0}, {0, -1, h}, {0, 1, h}};
       }},
      {"an edge that ends before the other", kEe,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2);
         return Points{Vec3d{-1, 0, 0}, {-h, 0, zero_or(r, h)}, {0, -1, 0}, {0, 1, 0}};
       }},
      {"two ends", kEe,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2);
         return Points{Vec3d{-1, 0, 0}, {-h, 0, 0}, {0, h, h}, {r.within(-2, 2), 1, 1}};
       }},
      {"edges of one plane", kEe,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2), e = power_of_ten(r, -8, -1);
         return Points{Vec3d{-1, 0, 0}, {-h, e, 0}, {0, -1, 0}, {0.2 * h * r.within(-1, 1), 1, 0}};
       }},
      {"a short edge", kEe,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2), e = power_of_ten(r, -9, -1);
         return Points{Vec3d{-e, 0, 0}, {e, 0, 0}, {0, -1, h}, {0, 1, h}};
       }},
      {"a loose edge", kVt,
       [](Random& r) {
         const double h = power_of_ten(r, -9, -2);
         const Vec3d a{0, 0, 0}, b{1, 0, 0};
         return Points{Vec3d{r.within(-0.5, 1.5), h, zero_or(r, h)}, a, b, b};
       }},
      {"a loose point", kVt,
       [](Random& r) {
         const double h = power_of_ten(r, -9, 0);
         const Vec3d a{0, 0, 0};
         return Points{times(h, r.vector(1)), a, a, a};
       }},
      {"an edge and a point", kEe,
       [](Random& r) {
         const double h = power_of_ten(r, -9, 0);
         const Vec3d a{r.within(-2, 2), h, zero_or(r, h)};
         return Points{a, a, {-1, 0, 0}, {1, 0, 0}};
       }},
      {"any triangle", kVt,
       [](Random& r) {
         return Points{r.vector(1), r.vector(1), r.vector(1), r.vector(1)};
       }},
      {"any edges", kEe,
       [](Random& r) {
         return Points{r.vector(1), r.vector(1), r.vector(1), r.vector(1)};
       }},
  };
  return all;
}

/// Turns the points by a random unit quaternion.
Points turned(const Points& points, Random& random) {
  double q[4], squared = 0;
  do {
    squared = 0;
    for (double& c : q) c = random.within(-1, 1), squared += c * c;
  } while (squared < 0.1 || squared > 1);
  for (double& c : q) c /= std::sqrt(squared);
  const auto [w, x, y, z] = q;
  const Vec3d rows[3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                         {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                         {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  Points out;
  for (size_t i = 0; i < 4; ++i)
    for (size_t k = 0; k < 3; ++k)
      out[i][k] = rows[k][0] * points[i][0] + rows[k][1] * points[i][1] + rows[k][2] * points[i][2];
  return out;
}

Points scaled_by(Points points, double scale) {
  for (Vec3d& p : points) p = times(scale, p);
  return points;
}

template <class Real>
CertifiedDistance certified(QueryKind kind, const Points& points) {
  Vec3<Real> p[4];
  for (size_t i = 0; i < 4; ++i)
    p[i] = {static_cast<Real>(points[i][0]), static_cast<Real>(points[i][1]), static_cast<Real>(points[i][2])};
  return kind == QueryKind::kEdgeEdge ? certified_distance<EdgeEdge>(p) : certified_distance<VertexTriangle>(p);
}

/// The largest component of the differences of both features' vertices.
double extent_of(QueryKind kind, const Points& p) {
  double extent = 0;
  for (size_t i = 0; i < first_feature(kind); ++i)
    for (size_t j = first_feature(kind); j < 4; ++j)
      for (size_t k = 0; k < 3; ++k) extent = std::max(extent, std::abs(p[i][k] - p[j][k]));
  return extent;
}

bool is_above(QueryKind kind, const Points& points, double distance) {
  return distance > 0 && judge_proximity(kind, points, std::nextafter(distance, 0));
}

/// By how much the distance is above the certified one at most, in quarters of kUnit of the extent and the distance.
int loss_in_quarters(QueryKind kind, const Points& points, const CertifiedDistance& found) {
  int low = 0, high = 4 * kStatedLoss + 1;
  while (low < high) {
    const int middle = (low + high) / 2;
    const double most = std::nextafter(found.value + middle * 0.25 * kUnit * (found.extent + found.value), HUGE_VAL);
    if (judge_proximity(kind, points, most))
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

class CertifiedDistances : public testing::TestWithParam<size_t> {};

TEST_P(CertifiedDistances, AreBelowTheTrueOnesByNoMoreThanStated) {
  const Family& family = families()[GetParam()];
  Random random(48 + GetParam());
  const uint64_t count = number_from_environment("COLLIDED_CERTIFIED_DISTANCES", 300);
  int above = 0, worst = 0, nothing = 0;
  for (uint64_t i = 0; i < count; ++i) {
    Points points = turned(family.make(random), random);
    if (random.chance(0.25)) {
      const Vec3d offset = random.vector(std::exp2(random.integer(0, 20)));
      for (Vec3d& p : points) p = plus(p, offset);
    }
    points = scaled_by(points, std::exp2(random.integer(-20, 20)));
    const CertifiedDistance found = certified<double>(family.kind, points);
    ASSERT_EQ(found.extent, extent_of(family.kind, points));
    above += is_above(family.kind, points, found.value);
    worst = std::max(worst, loss_in_quarters(family.kind, points, found));
    nothing += found.value == 0;
  }
  std::printf("%-40s %zu pairs, loses at most %.2f units, 0 for %d\n", family.name.c_str(), size_t{count}, 0.25 * worst,
              nothing);
  EXPECT_EQ(above, 0);
  EXPECT_LE(worst, 4 * kStatedLoss);
}

INSTANTIATE_TEST_SUITE_P(Families, CertifiedDistances, testing::Range(size_t{0}, families().size()));

// Numbers near the ends of double's range.
TEST(CertifiedDistance, IsNeverAboveTheTrueOneAtAnyScale) {
  Random random(3);
  int positive = 0;
  for (int i = 0; i < 2000; ++i) {
    const Family& family = families()[static_cast<size_t>(i) % families().size()];
    const int exponent = random.chance(0.5) ? random.integer(-1074, -960) : random.integer(600, 1000);
    const Points points = scaled_by(turned(family.make(random), random), std::exp2(exponent));
    const double found = certified<double>(family.kind, points).value;
    ASSERT_FALSE(is_above(family.kind, points, found)) << family.name << " at 2^" << exponent;
    positive += found > 0;
  }
  EXPECT_GT(positive, 1000);
}

bool same_bits(const CertifiedDistance& a, const CertifiedDistance& b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }

TEST(CertifiedDistance, DependsOnPositionsAlone) {
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    const Family& family = families()[static_cast<size_t>(i) % families().size()];
    Points points = turned(family.make(random), random);
    for (Vec3d& p : points)
      for (double& x : p) x = static_cast<float>(x);
    const CertifiedDistance found = certified<double>(family.kind, points);
    EXPECT_TRUE(same_bits(found, certified<float>(family.kind, points))) << family.name;
    CertifiedDistance far = certified<double>(family.kind, scaled_by(points, 0x1p30));
    far.value *= 0x1p-30, far.extent *= 0x1p-30;
    EXPECT_TRUE(same_bits(found, far)) << family.name;
  }
}

TEST(CertifiedDistance, OfFeaturesThatCoincideIsNothing) {
  const Vec3d p{1, 2, 3};
  for (const QueryKind kind : {QueryKind::kVertexTriangle, QueryKind::kEdgeEdge}) {
    const CertifiedDistance found = certified<double>(kind, Points{p, p, p, p});
    EXPECT_EQ(found.value, 0);
    EXPECT_EQ(found.along.length, 0);
    EXPECT_EQ(certified<double>(kind, Points{Vec3d{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {0, 1, 0}}).value, 0);
  }
}

}  // namespace
}  // namespace collided::test
