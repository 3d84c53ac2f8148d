// Tests crossings of an edge and a triangle against a judge that has no orientations: it solves linear equations in
// rationals for common points, and breaks ties with polynomials in e.

#include "gpu/exact/crossings.hpp"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "gpu/exact/integers.hpp"
#include "tests/gpu/exact/equations.hpp"

namespace collided::test {
namespace {

using Point = Vec3<double>;
using exact::fixed::EdgeTriangle;

/// u v a b c and their ids.
struct Case {
  Point p[5];
  uint32_t id[5] = {0, 1, 2, 3, 4};
};

EdgeTriangleVerdict decide(const Case& c) { return exact_edge_triangle(c.p, c.id); }

std::string text(const Case& c) {
  std::string s;
  for (int i = 0; i < 5; ++i)
    s += std::to_string(c.id[i]) + ": " + std::to_string(c.p[i].x) + ' ' + std::to_string(c.p[i].y) + ' ' +
         std::to_string(c.p[i].z) + '\n';
  return s;
}

std::array<double, 3> coordinates(const Point& p) { return {p.x, p.y, p.z}; }

// This part judges `meets`, and the point.

/// Weights of u v a b c, those of u v and those of a b c with the sum 1.
using Weights = std::array<mpq_class, 5>;

/// Solves for the weights of a common point, where only the vertices in the bit set `chosen` have weights other than 0.
/// Returns nothing unless there is exactly one solution. Weights may be negative.
std::optional<Weights> common_point(const Case& c, unsigned chosen) {
  std::vector<int> columns;
  for (int i = 0; i < 5; ++i)
    if (chosen >> i & 1) columns.push_back(i);
  FiveEquations m;
  for (size_t k = 0; k < columns.size(); ++k) {
    const int i = columns[k];
    const auto x = coordinates(c.p[i]);
    for (size_t row = 0; row < 3; ++row) m[row][k] = i < 2 ? x[row] : -x[row];
    m[i < 2 ? 3 : 4][k] = 1;
  }
  m[3][5] = m[4][5] = 1;
  const auto solution = only_solution(m, columns.size());
  if (!solution) return std::nullopt;
  Weights w;
  for (size_t k = 0; k < columns.size(); ++k) w[static_cast<size_t>(columns[k])] = (*solution)[k];
  return w;
}

struct Truth {
  bool meets = false, is_proper = false;  ///< proper: inside the edge and the triangle, in one point
  Weights first, last;                    ///< the first and the last common point on the edge
};

/// The weights of all common points form a polytope. At its corners the weights above 0 are the only solution for their
/// vertices, so trying all subsets of vertices finds every corner.
Truth truth_of(const Case& c) {
  Truth t;
  for (unsigned chosen = 1; chosen < 32; ++chosen) {
    const std::optional<Weights> w = common_point(c, chosen);
    if (!w || *std::min_element(w->begin(), w->end()) < 0) continue;
    if (!t.meets || (*w)[1] < t.first[1]) t.first = *w;
    if (!t.meets || (*w)[1] > t.last[1]) t.last = *w;
    t.meets = true;
    t.is_proper = t.is_proper || *std::min_element(w->begin(), w->end()) > 0;
  }
  return t;
}

// This part judges `crosses`: it moves coordinates, and takes the sign of the resulting polynomials for small e.

/// Maps a power of e to its factor.
using Polynomial = std::map<uint64_t, mpz_class>;

Polynomial operator+(Polynomial a, const Polynomial& b) {
  for (const auto& [power, factor] : b) a[power] += factor;
  return a;
}
Polynomial operator-(Polynomial a, const Polynomial& b) {
  for (const auto& [power, factor] : b) a[power] -= factor;
  return a;
}
Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  Polynomial product;
  for (const auto& [i, x] : a)
    for (const auto& [j, y] : b) product[i + j] += x * y;
  return product;
}
int sign(const Polynomial& a) {
  for (const auto& [power, factor] : a)
    if (factor != 0) return sgn(factor);
  return 0;
}

/// Coordinates are integers, ids are below 5.
struct Moved {
  std::array<std::array<Polynomial, 3>, 5> x;

  explicit Moved(const Case& c) {
    for (size_t i = 0; i < 5; ++i)
      for (size_t k = 0; k < 3; ++k)
        x[i][k] = {{0, mpz_class(coordinates(c.p[i])[k])}, {uint64_t{1} << (3 * c.id[i] + k), mpz_class(1)}};
  }
  int side(size_t i, size_t j, size_t k, size_t l) const {
    const auto d = [&](size_t to, size_t axis) { return x[to][axis] - x[i][axis]; };
    const auto minor = [&](size_t s, size_t t) { return d(j, s) * d(k, t) - d(j, t) * d(k, s); };
    return sign(d(l, 0) * minor(1, 2) + d(l, 1) * minor(2, 0) + d(l, 2) * minor(0, 1));
  }
};

struct Crossing {
  bool crosses, from_front;
};
Crossing crossing_of(const Case& c) {
  const Moved m(c);
  const int u = m.side(2, 3, 4, 0), v = m.side(2, 3, 4, 1), first = m.side(0, 1, 2, 3);
  for (const int s : {u, v, first}) EXPECT_NE(s, 0) << "ties are broken";
  return {u != v && m.side(0, 1, 3, 4) == first && m.side(0, 1, 4, 2) == first, u > 0};
}

// The rest compares.

constexpr double kRoundingOfPoints = 0x1p-49;

void expect_near(double found, const mpq_class& truth, const Case& c) {
  EXPECT_LE(abs(mpq_class(found) - truth), kRoundingOfPoints) << found << ' ' << truth.get_d() << '\n' << text(c);
}

/// Expects the middle of the common part. Weights need not be unique, but have to give that point.
void expect_point(const EdgeTriangleVerdict& v, const Truth& t, const Case& c) {
  const mpq_class along = (t.first[1] + t.last[1]) / 2;
  expect_near(v.along, along, c);
  ASSERT_TRUE(v.along >= 0 && v.along <= 1 && v.weights[0] >= 0 && v.weights[1] >= 0);
  ASSERT_LE(v.weights[0] + v.weights[1], 1);
  const mpq_class b = v.weights[0], w = v.weights[1], a = 1 - b - w;
  for (size_t k = 0; k < 3; ++k) {
    std::array<mpq_class, 5> x;
    for (size_t i = 0; i < 5; ++i) x[i] = coordinates(c.p[i])[k];
    const mpq_class truth = x[0] + along * (x[1] - x[0]),
                    extent = std::max({x[2], x[3], x[4]}) - std::min({x[2], x[3], x[4]});
    EXPECT_LE(abs(a * x[2] + b * x[3] + w * x[4] - truth), 4 * kRoundingOfPoints * extent) << text(c);
  }
}
void expect_weights(const EdgeTriangleVerdict& v, const Truth& t, const Case& c) {
  expect_near(v.weights[0], (t.first[3] + t.last[3]) / 2, c);
  expect_near(v.weights[1], (t.first[4] + t.last[4]) / 2, c);
}
bool has_area(const Case& c) {
  for (int i = 0; i < 3; ++i) {
    const auto a = coordinates(c.p[2]), b = coordinates(c.p[3]), d = coordinates(c.p[4]);
    const size_t s = static_cast<size_t>(i), t = (s + 1) % 3;
    if (mpq_class(b[s] - mpq_class(a[s])) * (d[t] - mpq_class(a[t])) !=
        mpq_class(b[t] - mpq_class(a[t])) * (d[s] - mpq_class(a[s])))
      return true;
  }
  return false;
}

void expect_truth(const EdgeTriangleVerdict& v, const Truth& t, const Case& c) {
  ASSERT_EQ(v.meets, t.meets) << text(c);
  ASSERT_EQ(v.touches, t.meets && !t.is_proper) << text(c);
  if (!v.meets) return;
  expect_point(v, t, c);
  if (has_area(c)) expect_weights(v, t, c);
}

bool same(const EdgeTriangleVerdict& a, const EdgeTriangleVerdict& b) {
  return a.crosses == b.crosses && a.touches == b.touches && a.meets == b.meets && a.from_front == b.from_front &&
         a.along == b.along && a.weights[0] == b.weights[0] && a.weights[1] == b.weights[1];
}

/// Expects the same bits from numbers that are wider than necessary.
void expect_same_in_any_size(const EdgeTriangleVerdict& v, const Case& c) {
  const std::vector<Vec3<exact::Number>> numbers = exact::integers(c.p);
  EXPECT_TRUE(same(EdgeTriangle(numbers.data(), c.id).verdict(), v)) << text(c);
  exact::fixed::Unit unit;
  unit.see(c.p);
  const auto wide = [&](const auto* p) { EXPECT_TRUE(same(EdgeTriangle(p, c.id).verdict(), v)) << text(c); };
  if (unit.fits<2>()) exact::fixed::use_counted<2>(unit, c.p, wide);
}

/// Returns points of a lattice with `size` coordinates per axis, and ids in random order.
Case any_lattice_case(std::mt19937& random, int size) {
  std::uniform_int_distribution<int> coordinate(0, size - 1);
  Case c;
  for (Point& p : c.p)
    for (double* x : {&p.x, &p.y, &p.z}) *x = coordinate(random);
  std::shuffle(std::begin(c.id), std::end(c.id), random);
  return c;
}

TEST(Crossings, FullOfTies) {
  std::mt19937 random(1);
  int proper = 0, touching = 0, crossing_by_ties = 0, without_area = 0, apart = 0;
  for (int i = 0; i < 12000; ++i) {
    const Case c = any_lattice_case(random, 2 + i % 4);
    const Truth t = truth_of(c);
    const EdgeTriangleVerdict v = decide(c);
    expect_truth(v, t, c);
    const Crossing expected = crossing_of(c);
    ASSERT_EQ(v.crosses, expected.crosses) << text(c);
    ASSERT_EQ(v.from_front, expected.crosses && expected.from_front) << text(c);
    ASSERT_TRUE(v.meets || !v.crosses) << text(c);
    ASSERT_TRUE(v.touches || v.crosses == v.meets) << text(c);
    expect_same_in_any_size(v, c);
    proper += t.is_proper, touching += v.touches, crossing_by_ties += v.touches && v.crosses, apart += !t.meets;
    without_area += v.crosses && !has_area(c);
    if (HasFailure()) return;
  }
  for (const int count : {proper, touching, crossing_by_ties, without_area, apart}) EXPECT_GT(count, 50);
}

TEST(Crossings, InOnePlane) {
  std::mt19937 random(2);
  int met = 0, crossed = 0;
  for (int i = 0; i < 4000; ++i) {
    Case c = any_lattice_case(random, 4);
    const int slope = static_cast<int>(random() % 3);
    for (Point& p : c.p) {
      if (i % 3 == 0) p.y = p.x;  // on a line
      p.z = p.x + slope * p.y;
      if (i % 2 == 0) std::swap(p.x, p.z);
    }
    const Truth t = truth_of(c);
    const EdgeTriangleVerdict v = decide(c);
    expect_truth(v, t, c);
    ASSERT_EQ(v.crosses, crossing_of(c).crosses) << text(c);
    expect_same_in_any_size(v, c);
    met += v.meets, crossed += v.crosses;
    if (HasFailure()) return;
  }
  EXPECT_GT(met, 500);
  EXPECT_GT(crossed, 100);
}

/// One system of equations decides in general position.
TEST(Crossings, OfAnySize) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::uniform_int_distribution<int> exponent(-300, 300);
  int crossed = 0, ties = 0, too_wide = 0;
  for (int i = 0; i < 100000; ++i) {
    Case c;
    const double unit = std::ldexp(1.0, exponent(random));
    const Point offset = i % 3 == 0 ? Point{0x1p40 * uniform(random), 0x1p40, -0x1p40} : Point{0, 0, 0};
    for (Point& p : c.p) {
      const double own = i % 8 == 1 ? std::ldexp(1.0, exponent(random) / 2) : 1;
      p = Point{uniform(random), uniform(random), uniform(random)} + offset;
      p = unit * own * p;
    }
    std::shuffle(std::begin(c.id), std::end(c.id), random);
    const std::optional<Weights> w = common_point(c, 31);
    const bool crosses = w && *std::min_element(w->begin(), w->end()) >= 0;
    const EdgeTriangleVerdict v = decide(c);
    ties += v.touches;
    if (v.touches) continue;
    ASSERT_EQ(v.crosses, crosses) << text(c);
    ASSERT_EQ(v.meets, crosses) << text(c);
    EdgeTriangleVerdict fixed;
    if (exact::fixed::decide_edge_triangle(c.p, c.id, fixed))
      ASSERT_TRUE(same(fixed, v));
    else
      ++too_wide;
    if (!crosses) continue;
    ++crossed;
    expect_point(v, {true, true, *w, *w}, c);
    expect_weights(v, {true, true, *w, *w}, c);
    if (i % 16 == 0) expect_same_in_any_size(v, c);
    if (HasFailure()) return;
  }
  EXPECT_GT(crossed, 1000);
  EXPECT_GT(too_wide, 1000);
  EXPECT_LT(ties, 100);
}

/// Volumes have more bits than a double here, so rounded weights of b and c would have a sum above 1.
TEST(Crossings, OnASideHaveWeightsOfAtMostOne) {
  std::mt19937 random(6);
  std::uniform_int_distribution<int> coordinate(-1000000, 1000000), share(0, 1024);
  const auto any_point = [&] {
    return Point{1024.0 * coordinate(random), 1024.0 * coordinate(random), 1024.0 * coordinate(random)};
  };
  for (int i = 0; i < 1000; ++i) {
    Case c;
    for (Point& p : c.p) p = any_point();
    const Point on_side = c.p[3] + share(random) / 1024.0 * (c.p[4] - c.p[3]), way = any_point();
    c.p[0] = on_side - way;
    c.p[1] = on_side + 3.0 * way;
    const EdgeTriangleVerdict v = decide(c);
    EXPECT_TRUE(v.touches);
    expect_truth(v, truth_of(c), c);
    if (HasFailure()) return;
  }
}

TEST(Crossings, ExtremeNumbers) {
  const double tiny = 0x1p-1074, small = 1e-300, large = 1e300;
  const std::vector<Case> cases = {
      {{{tiny, tiny, -tiny}, {tiny, tiny, tiny}, {0, 0, 0}, {large, 0, 0}, {0, large, 0}}},
      {{{-tiny, tiny, -large}, {-tiny, tiny, large}, {0, 0, 0}, {large, 0, 0}, {0, large, 0}}},
      {{{small, small, -large}, {small, small, small}, {0, 0, 0}, {large, 0, 0}, {0, large, tiny}}},
      {{{small, 0, 0}, {large, 0, 0}, {0, 0, 0}, {large, 0, 0}, {0, large, 0}}},
      {{{-large, small, 0}, {large, small, 0}, {0, 0, 0}, {small, 0, 0}, {0, large, 0}}},
      {{{-large, tiny, 0}, {large, tiny, 0}, {0, tiny, 0}, {small, tiny, 0}, {large, tiny, 0}}},
      {{{1, 1, 0}, {1, 1, 0}, {0, 0, -0.0}, {4, 0, 0}, {0, 4, 0}}},
      {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}},
      {{{0, 0, 0}, {0, 0, 0}, {tiny, 0, 0}, {tiny, 0, 0}, {tiny, 0, 0}}},
  };
  int met = 0;
  for (Case c : cases) {
    const Truth t = truth_of(c);
    do {
      const EdgeTriangleVerdict v = decide(c);
      expect_truth(v, t, c);
      EXPECT_TRUE(v.meets || !v.crosses) << text(c);
      expect_same_in_any_size(v, c);
      met += v.meets;
    } while (std::next_permutation(std::begin(c.id), std::end(c.id)));
  }
  EXPECT_EQ(met, 7 * 120);
}

TEST(Crossings, HaveAPointAndASide) {
  const Case c{{{1, 2, 3}, {1, 2, -1}, {0, 0, 0}, {4, 0, 0}, {0, 8, 0}}};
  const EdgeTriangleVerdict v = decide(c);
  EXPECT_TRUE(v.crosses && v.meets && !v.touches && v.from_front);
  EXPECT_EQ(v.along, 0.75);
  EXPECT_EQ(v.weights[0], 0.25);
  EXPECT_EQ(v.weights[1], 0.25);
  const Case back{{c.p[1], c.p[0], c.p[2], c.p[3], c.p[4]}};
  EXPECT_FALSE(decide(back).from_front);
  EXPECT_EQ(decide(back).along, 0.25);
  const Case turned{{c.p[0], c.p[1], c.p[2], c.p[4], c.p[3]}};
  EXPECT_FALSE(decide(turned).from_front);
}

Case with_order(const Case& c, const std::array<size_t, 5>& order) {
  Case r;
  for (size_t i = 0; i < 5; ++i) r.p[i] = c.p[order[i]], r.id[i] = c.id[order[i]];
  return r;
}
template <class Change>
Case with_points(Case c, Change change) {
  for (Point& p : c.p) p = change(p);
  return c;
}

TEST(Crossings, DependOnNothingElse) {
  std::mt19937 random(4);
  for (int i = 0; i < 20000; ++i) {
    const Case c = any_lattice_case(random, 2 + i % 4);
    const EdgeTriangleVerdict v = decide(c);
    Case renumbered = c;
    for (uint32_t& id : renumbered.id) id = 1000000000u * id + 7;
    ASSERT_TRUE(same(decide(renumbered), v)) << text(c);
    ASSERT_TRUE(same(decide(with_points(c, [](const Point& p) { return p + Point{0x1p40, -0x1p40, 3}; })), v));
    ASSERT_TRUE(same(decide(with_points(c, [](const Point& p) { return 0x1p-1074 * p; })), v));
    ASSERT_TRUE(same(decide(with_points(c, [](const Point& p) { return 0x1p1000 * p; })), v));

    const EdgeTriangleVerdict back = decide(with_order(c, {1, 0, 2, 3, 4})),
                              turned = decide(with_order(c, {0, 1, 3, 4, 2})),
                              flipped = decide(with_order(c, {0, 1, 2, 4, 3}));
    for (const EdgeTriangleVerdict& other : {back, turned, flipped}) {
      ASSERT_EQ(other.meets, v.meets);
      ASSERT_EQ(other.touches, v.touches);
      ASSERT_EQ(other.crosses, v.crosses) << text(c);
    }
    ASSERT_EQ(turned.from_front, v.from_front);
    ASSERT_EQ(flipped.from_front, v.crosses && !v.from_front);
    ASSERT_EQ(back.from_front, v.crosses && !v.from_front);

    Case shuffled = c;
    std::shuffle(std::begin(shuffled.id), std::end(shuffled.id), random);
    const EdgeTriangleVerdict other = decide(shuffled);
    ASSERT_EQ(other.meets, v.meets);
    ASSERT_EQ(other.touches, v.touches);
    ASSERT_EQ(other.along, v.along);
    ASSERT_TRUE(v.touches || same(other, v)) << text(c);
  }
}

/// Counts crossings between edges of one triangle and the other triangle. Both are given by indices of points.
int ends_of(const std::array<size_t, 3>& s, const std::array<size_t, 3>& t, const std::vector<Point>& p,
            const std::vector<uint32_t>& id) {
  int ends = 0;
  for (const auto& [from, to] : {std::pair(s, t), std::pair(t, s)})
    for (size_t i = 0; i < 3; ++i) {
      const size_t u = from[i], v = from[(i + 1) % 3];
      if (std::count(to.begin(), to.end(), u) + std::count(to.begin(), to.end(), v) > 0) continue;
      ends +=
          decide({{p[u], p[v], p[to[0]], p[to[1]], p[to[2]]}, {id[u], id[v], id[to[0]], id[to[1]], id[to[2]]}}).crosses;
    }
  return ends;
}

TEST(Crossings, EndContours) {
  std::mt19937 random(5);
  std::map<int, int> ends_apart, ends_at_corner;
  for (int i = 0; i < 20000; ++i) {
    std::uniform_int_distribution<int> coordinate(0, 1 + i % 4);
    std::vector<Point> p(6);
    for (Point& q : p)
      for (double* x : {&q.x, &q.y, &q.z}) *x = coordinate(random);
    std::vector<uint32_t> id(6);
    std::iota(id.begin(), id.end(), 0u);
    std::shuffle(id.begin(), id.end(), random);
    ++ends_apart[ends_of({0, 1, 2}, {3, 4, 5}, p, id)];
    ++ends_at_corner[ends_of({0, 1, 2}, {0, 4, 5}, p, id)];
    ASSERT_EQ(ends_of({0, 1, 2}, {0, 1, 5}, p, id), 0);
  }
  EXPECT_EQ(ends_apart[0] + ends_apart[2], 20000);
  EXPECT_EQ(ends_at_corner[0] + ends_at_corner[1], 20000);
  EXPECT_GT(ends_apart[2], 2000);
  EXPECT_GT(ends_at_corner[1], 1000);
}

}  // namespace
}  // namespace collided::test
