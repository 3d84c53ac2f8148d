// Tests rays in the direction of z against judges that look along other directions: with polynomials in e, which break
// ties, and in rationals. Where a vertex is on a triangle, the judge solves equations for its weights.

#include "gpu/exact/rays.hpp"

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

namespace collided::test {
namespace {

using Point = Vec3<double>;
using exact::fixed::RayTriangle;

/// A closed mesh and a vertex, which is the last point.
struct Case {
  std::vector<Point> p;
  std::vector<uint32_t> id;
  std::vector<std::array<size_t, 3>> triangles;
};

std::string text(const Case& c) {
  std::string s;
  for (size_t i = 0; i < c.p.size(); ++i)
    s += std::to_string(c.id[i]) + ": " + std::to_string(c.p[i].x) + ' ' + std::to_string(c.p[i].y) + ' ' +
         std::to_string(c.p[i].z) + '\n';
  return s;
}

bool same(const RayVerdict& a, const RayVerdict& b) { return a.crossing == b.crossing && a.is_on == b.is_on; }

/// Expects the same from numbers of any size.
RayVerdict decide(const Case& c, const std::array<size_t, 3>& t) {
  const size_t v = c.p.size() - 1;
  const Point p[] = {c.p[v], c.p[t[0]], c.p[t[1]], c.p[t[2]]};
  const uint32_t id[] = {c.id[v], c.id[t[0]], c.id[t[1]], c.id[t[2]]};
  const RayVerdict verdict = exact_ray(p, id);
  const auto numbers = exact::integers(p);
  EXPECT_TRUE(same(RayTriangle(numbers.data(), id).verdict(), verdict)) << text(c);
  RayVerdict fixed;
  EXPECT_TRUE(!exact::fixed::decide_ray(p, id, fixed) || same(fixed, verdict)) << text(c);
  return verdict;
}

struct Found {
  int winding = 0;
  std::vector<bool> is_on;

  bool operator==(const Found&) const = default;
};
Found find(const Case& c) {
  Found f;
  for (const auto& t : c.triangles) {
    const RayVerdict verdict = decide(c, t);
    f.winding += verdict.crossing;
    f.is_on.push_back(verdict.is_on);
  }
  return f;
}
bool is_on_mesh(const Found& f) { return std::count(f.is_on.begin(), f.is_on.end(), true) > 0; }

// Vectors of any numbers.

template <class T>
using Vector = std::array<T, 3>;
template <class T>
Vector<T> minus(const Vector<T>& a, const Vector<T>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class T>
T determinant(const Vector<T>& a, const Vector<T>& b, const Vector<T>& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

// This part judges windings of moved vertices.

/// Maps a power of e to its factor.
class Polynomial {
 public:
  Polynomial() = default;
  Polynomial(int64_t constant) : factors_{{0, mpz_class(static_cast<long>(constant))}} {}  // NOLINT: as numbers do
  void add(uint64_t power, const mpz_class& factor) { factors_[power] += factor; }
  int sign() const {
    for (const auto& [power, factor] : factors_)
      if (factor != 0) return sgn(factor);
    return 0;
  }
  friend Polynomial operator+(Polynomial a, const Polynomial& b) {
    for (const auto& [power, factor] : b.factors_) a.add(power, factor);
    return a;
  }
  friend Polynomial operator-(Polynomial a, const Polynomial& b) {
    for (const auto& [power, factor] : b.factors_) a.add(power, -factor);
    return a;
  }
  friend Polynomial operator*(const Polynomial& a, const Polynomial& b) {
    Polynomial product;
    for (const auto& [i, x] : a.factors_)
      for (const auto& [j, y] : b.factors_) product.add(i + j, x * y);
    return product;
  }

 private:
  std::map<uint64_t, mpz_class> factors_;
};

/// Coordinates are integers, ids are below 20.
std::vector<Vector<Polynomial>> moved(const Case& c) {
  std::vector<Vector<Polynomial>> moved;
  for (size_t i = 0; i < c.p.size(); ++i) {
    const double x[] = {c.p[i].x, c.p[i].y, c.p[i].z};
    moved.emplace_back();
    for (size_t k = 0; k < 3; ++k) {
      moved[i][k] = static_cast<int64_t>(x[k]);
      moved[i][k].add(uint64_t{1} << (3 * c.id[i] + k), 1);
    }
  }
  return moved;
}

/// The crossing of a triangle and the ray in direction d.
int moved_crossing(const std::vector<Vector<Polynomial>>& p, const std::array<size_t, 3>& t,
                   const Vector<Polynomial>& d) {
  const Vector<Polynomial>&v = p.back(), a = minus(p[t[0]], v), b = minus(p[t[1]], v), c = minus(p[t[2]], v);
  const int side = determinant(d, a, b).sign(), height = determinant(a, b, c).sign();
  EXPECT_TRUE(side != 0 && height != 0) << "ties are broken";
  const bool passes = determinant(d, b, c).sign() == side && determinant(d, c, a).sign() == side;
  return passes && height == side ? side : 0;
}

void expect_moved_crossings(const Case& c) {
  const auto p = moved(c);
  const Vector<Polynomial> up{0, 0, 1};
  for (const auto& t : c.triangles) ASSERT_EQ(decide(c, t).crossing, moved_crossing(p, t, up)) << text(c);
  int winding = 0;
  for (const auto& t : c.triangles) winding += moved_crossing(p, t, {3, -5, 7});
  ASSERT_EQ(find(c).winding, winding) << text(c);
}

// This part judges in rationals.

Vector<mpq_class> rational(const Point& p) { return {mpq_class(p.x), mpq_class(p.y), mpq_class(p.z)}; }

/// Solves for weights above 0 with the sum 1 of the corners in the bit set `chosen`, which give v. Returns true if
/// there is exactly one solution.
bool is_inside_of(const Case& c, const std::array<size_t, 3>& t, unsigned chosen) {
  std::vector<Vector<mpq_class>> corners;
  for (size_t k = 0; k < 3; ++k)
    if (chosen >> k & 1) corners.push_back(rational(c.p[t[k]]));
  const Vector<mpq_class> v = rational(c.p.back());
  std::array<std::array<mpq_class, 4>, 4> m;  // a row an equation, column 3 is its right side
  for (size_t row = 0; row < 4; ++row) {
    for (size_t k = 0; k < corners.size(); ++k) m[row][k] = row < 3 ? corners[k][row] : mpq_class(1);
    m[row][3] = row < 3 ? v[row] : mpq_class(1);
  }
  for (size_t k = 0; k < corners.size(); ++k) {
    size_t pivot = k;
    while (pivot < 4 && m[pivot][k] == 0) ++pivot;
    if (pivot == 4) return false;
    std::swap(m[k], m[pivot]);
    for (size_t row = 0; row < 4; ++row) {
      if (row == k) continue;
      const mpq_class factor = m[row][k] / m[k][k];
      for (size_t j = 0; j < 4; ++j) m[row][j] -= factor * m[k][j];
    }
  }
  for (size_t row = 0; row < 4; ++row)
    if (row < corners.size() ? m[row][3] / m[row][row] <= 0 : m[row][3] != 0) return false;
  return true;
}
bool is_on(const Case& c, const std::array<size_t, 3>& t) {
  for (unsigned chosen = 1; chosen < 8; ++chosen)
    if (is_inside_of(c, t, chosen)) return true;
  return false;
}

bool has_area(const Vector<mpq_class>& ab, const Vector<mpq_class>& ac) {
  for (size_t k = 0; k < 3; ++k)
    if (ab[k] * ac[(k + 1) % 3] != ab[(k + 1) % 3] * ac[k]) return true;
  return false;
}

/// Returns nothing if the ray meets an edge, or is in line with a triangle's plane.
std::optional<int> winding_along(const Case& c, const Vector<mpq_class>& d) {
  const Vector<mpq_class> v = rational(c.p.back());
  int winding = 0;
  for (const auto& t : c.triangles) {
    const Vector<mpq_class> a = rational(c.p[t[0]]), ab = minus(rational(c.p[t[1]]), a),
                            ac = minus(rational(c.p[t[2]]), a), av = minus(v, a);
    const mpq_class all = determinant(d, ab, ac);
    if (all == 0) {
      if (has_area(ab, ac)) return std::nullopt;
      continue;
    }
    // v + s d = a + x ab + y ac
    const mpq_class s = -determinant(av, ab, ac) / all, x = determinant(d, av, ac) / all,
                    y = determinant(d, ab, av) / all;
    if (x < 0 || y < 0 || x + y > 1 || s < 0) continue;
    if (x == 0 || y == 0 || x + y == 1 || s == 0) return std::nullopt;
    winding += sgn(all);
  }
  return winding;
}
int real_winding(const Case& c, std::mt19937& random) {
  for (;;) {
    const auto any = [&] { return mpq_class(static_cast<long>(random() % 200001) - 100000); };
    if (const auto winding = winding_along(c, {any(), any(), any()})) return *winding;
  }
}

/// Returns the real winding number unless the vertex is on the mesh.
std::optional<int> expect_truth(const Case& c, std::mt19937& random) {
  const Found f = find(c);
  bool is_on_any = false;
  for (size_t i = 0; i < c.triangles.size(); ++i) {
    const bool truth = is_on(c, c.triangles[i]);
    EXPECT_EQ(f.is_on[i], truth) << text(c);
    is_on_any = is_on_any || truth;
  }
  if (is_on_any) return std::nullopt;
  const int winding = real_winding(c, random);
  EXPECT_EQ(f.winding, winding) << text(c);
  return winding;
}

// The rest makes cases.

const std::vector<std::array<size_t, 3>> kTetrahedron = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
const std::vector<std::array<size_t, 3>> kOctahedron = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                        {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
const std::vector<std::array<size_t, 3>> kBox = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

Point any_lattice_point(std::mt19937& random, int size) {
  std::uniform_int_distribution<int> coordinate(0, size - 1);
  const double x = coordinate(random), y = coordinate(random);
  return {x, y, static_cast<double>(coordinate(random))};
}

/// A body whose vertices are anywhere on a lattice, so that it may run through itself or be flat.
Case any_lattice_case(std::mt19937& random, int size) {
  Case c;
  c.triangles = random() % 2 == 0 ? kTetrahedron : kOctahedron;
  const size_t count = c.triangles == kTetrahedron ? 4 : 6;
  for (size_t i = 0; i <= count; ++i) c.p.push_back(any_lattice_point(random, size));
  c.id.resize(c.p.size());
  std::iota(c.id.begin(), c.id.end(), 0);
  std::shuffle(c.id.begin(), c.id.end(), random);
  return c;
}
template <class Change>
Case with_points(Case c, Change change) {
  for (Point& p : c.p) p = change(p);
  return c;
}

TEST(Rays, FullOfTies) {
  std::mt19937 random(1);
  std::map<int, int> windings;
  int on = 0;
  for (int i = 0; i < 8000; ++i) {
    const Case c = any_lattice_case(random, 2 + i % 8);
    if (i % 3 == 0) expect_moved_crossings(c);
    const auto winding = expect_truth(c, random);
    if (winding)
      ++windings[*winding];
    else
      ++on;
    if (HasFailure()) return;
  }
  for (const int winding : {-1, 0, 1}) EXPECT_GT(windings[winding], 20);
  EXPECT_GT(on, 500);
}

/// A box has vertical faces, and edges and corners above each other. The vertex takes all places in and around it.
TEST(Rays, AroundABox) {
  std::mt19937 random(2);
  Case c;
  c.triangles = kBox;
  for (int i = 0; i < 8; ++i) c.p.push_back({4.0 * (i & 1), 4.0 * (i >> 1 & 1), 4.0 * (i >> 2)});
  c.p.emplace_back();
  c.id.resize(9);
  std::iota(c.id.begin(), c.id.end(), 0);
  for (int place = 0; place < 7 * 7 * 7; ++place) {
    const double x = place % 7 - 1, y = place / 7 % 7 - 1, z = place / 49 - 1;
    c.p.back() = {x, y, z};
    std::shuffle(c.id.begin(), c.id.end(), random);
    const auto is_inside = [](double at) { return at > 0 && at < 4; };
    const auto is_outside = [](double at) { return at < 0 || at > 4; };
    const auto winding = expect_truth(c, random);
    if (is_outside(x) || is_outside(y) || is_outside(z))
      EXPECT_EQ(winding, 0) << text(c);
    else if (is_inside(x) && is_inside(y) && is_inside(z))
      EXPECT_EQ(winding, 1) << text(c);
    else
      EXPECT_EQ(winding, std::nullopt) << text(c);
    if (place % 10 == 0) expect_moved_crossings(c);
    if (HasFailure()) return;
  }
}

TEST(Rays, OfAnySize) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::uniform_int_distribution<int> exponent(-300, 300);
  int inside = 0;
  for (int i = 0; i < 3000; ++i) {
    Case c = any_lattice_case(random, 2);
    const double unit = std::ldexp(1.0, exponent(random));
    const Point offset = i % 3 == 0 ? Point{0x1p40 * uniform(random), 0x1p40, -0x1p40} : Point{0, 0, 0};
    for (Point& p : c.p) {
      const double own = i % 8 == 1 ? std::ldexp(1.0, exponent(random) / 2) : 1;
      p = unit * own * (Point{uniform(random), uniform(random), uniform(random)} + offset);
    }
    const auto winding = expect_truth(c, random);
    EXPECT_TRUE(winding) << "no ties";
    inside += winding && *winding != 0;
    if (HasFailure()) return;
  }
  EXPECT_GT(inside, 50);
}

TEST(Rays, ExtremeNumbers) {
  const double tiny = 0x1p-1074, large = 1e300;
  const Case c{{{0, 0, -large}, {large, 0, tiny}, {0, large, tiny}, {-tiny, -tiny, tiny}, {0, 0, 0}},
               {3, 1, 4, 0, 2},
               kTetrahedron};
  std::mt19937 random(4);
  for (const double z : {-2 * large * 0.8, -tiny, 0.0, tiny, 2 * tiny, 1.0})
    for (const double x : {-tiny, 0.0, tiny, large}) {
      Case moved = c;
      moved.p.back() = {x, 0, z};
      expect_truth(moved, random);
    }
}

TEST(Rays, DependOnNothingElse) {
  std::mt19937 random(5);
  for (int i = 0; i < 3000; ++i) {
    const Case c = any_lattice_case(random, 2 + i % 4);
    const Found f = find(c);
    Case renumbered = c;
    for (uint32_t& id : renumbered.id) id = 600000000u * id + 7;
    ASSERT_EQ(find(renumbered), f) << text(c);
    ASSERT_EQ(find(with_points(c, [](const Point& p) { return p + Point{0x1p40, -0x1p40, 3}; })), f) << text(c);
    ASSERT_EQ(find(with_points(c, [](const Point& p) { return 0x1p-300 * p; })), f) << text(c);
    ASSERT_EQ(find(with_points(c, [](const Point& p) { return 0x1p-1074 * p; })), f) << text(c);
    Case turned = c, flipped = c;
    for (auto& t : turned.triangles) t = {t[1], t[2], t[0]};
    for (auto& t : flipped.triangles) t = {t[0], t[2], t[1]};
    ASSERT_EQ(find(turned), f) << text(c);
    ASSERT_EQ(find(flipped), (Found{-f.winding, f.is_on})) << text(c);
    if (HasFailure()) return;
  }
}

/// Real answers do not depend on ids.
TEST(Rays, WithAnyIds) {
  std::mt19937 random(6);
  for (int i = 0; i < 100; ++i) {
    Case c = any_lattice_case(random, 3);
    if (c.triangles != kTetrahedron) continue;
    const Found f = find(c);
    std::sort(c.id.begin(), c.id.end());
    do {
      const Found other = find(c);
      ASSERT_EQ(other.is_on, f.is_on);
      ASSERT_TRUE(is_on_mesh(f) || other.winding == f.winding) << text(c);
      ASSERT_LE(std::abs(other.winding), 1);
    } while (std::next_permutation(c.id.begin(), c.id.end()));
  }
}

}  // namespace
}  // namespace collided::test
