// Tests what two bodies have in common. The judge of volumes cuts bodies into tetrahedra and clips these by planes, in
// rationals. The judge of triangles solves equations for all their common points.

#include "gpu/exact/overlap.hpp"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "tests/gpu/exact/closed_meshes.hpp"
#include "tests/gpu/exact/equations.hpp"

namespace collided::test {
namespace {

using Vector = std::array<mpq_class, 3>;

const Triangles kOctahedron = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};

Mesh cube(double from, double to) { return box({from, from, from}, {to, to, to}); }

// The judge of volumes.

Vector rational(const Point& p) { return {mpq_class(p.x), mpq_class(p.y), mpq_class(p.z)}; }
Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
mpq_class product(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector cross_product(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

using Tetrahedron = std::array<Vector, 4>;
mpq_class six_volumes(const Tetrahedron& t) { return product(t[1] - t[0], cross_product(t[2] - t[0], t[3] - t[0])); }

/// The points x with normal . x <= limit.
struct HalfSpace {
  Vector normal;
  mpq_class limit;
};

void add_prism(const std::array<Vector, 3>& a, const std::array<Vector, 3>& b, std::vector<Tetrahedron>& out) {
  out.push_back({a[0], a[1], a[2], b[2]});
  out.push_back({a[0], a[1], b[1], b[2]});
  out.push_back({a[0], b[0], b[1], b[2]});
}
void add_clipped(const Tetrahedron& t, const HalfSpace& space, std::vector<Tetrahedron>& out) {
  std::vector<Vector> in, beyond;
  const auto height = [&](const Vector& x) { return mpq_class(product(space.normal, x) - space.limit); };
  for (const Vector& x : t) (height(x) <= 0 ? in : beyond).push_back(x);
  const auto cut = [&](size_t i, size_t j) {
    const mpq_class from = height(in[i]), share = from / (from - height(beyond[j]));
    const Vector way = beyond[j] - in[i];
    return Vector{in[i][0] + share * way[0], in[i][1] + share * way[1], in[i][2] + share * way[2]};
  };
  if (in.size() == 4) out.push_back(t);
  if (in.size() == 1) out.push_back({in[0], cut(0, 0), cut(0, 1), cut(0, 2)});
  if (in.size() == 2) add_prism({in[0], cut(0, 0), cut(0, 1)}, {in[1], cut(1, 0), cut(1, 1)}, out);
  if (in.size() == 3) add_prism({in[0], in[1], in[2]}, {cut(0, 0), cut(1, 0), cut(2, 0)}, out);
}

/// Four half spaces of a tetrahedron whose six volumes are not 0.
std::vector<HalfSpace> half_spaces(const Tetrahedron& t) {
  std::vector<HalfSpace> spaces;
  for (size_t i = 0; i < 4; ++i) {
    const Vector &a = t[(i + 1) % 4], &b = t[(i + 2) % 4], &c = t[(i + 3) % 4];
    HalfSpace space{cross_product(b - a, c - a), 0};
    space.limit = product(space.normal, a);
    if (product(space.normal, t[i]) > space.limit) {
      for (mpq_class& x : space.normal) x = -x;
      space.limit = -space.limit;
    }
    spaces.push_back(space);
  }
  return spaces;
}
mpq_class common_six_volumes(const Tetrahedron& a, const Tetrahedron& b) {
  std::vector<Tetrahedron> left = {a};
  for (const HalfSpace& space : half_spaces(b)) {
    std::vector<Tetrahedron> next;
    for (const Tetrahedron& t : left) add_clipped(t, space, next);
    left = std::move(next);
  }
  mpq_class sum;
  for (const Tetrahedron& t : left) sum += abs(six_volumes(t));
  return sum;
}

/// A winding number is the sum of those of the tetrahedra between a vertex and the triangles, by their signs.
std::vector<Tetrahedron> tetrahedra_of(const Mesh& mesh) {
  std::vector<Tetrahedron> result;
  for (const auto& t : mesh.triangles) {
    const Tetrahedron tetrahedron = {rational(mesh.p[0]), rational(mesh.p[t[0]]), rational(mesh.p[t[1]]),
                                     rational(mesh.p[t[2]])};
    if (six_volumes(tetrahedron) != 0) result.push_back(tetrahedron);
  }
  return result;
}
mpq_class volume_in_rationals(const Mesh& a, const Mesh& b) {
  mpq_class sum;
  const auto second = tetrahedra_of(b);
  for (const Tetrahedron& t : tetrahedra_of(a))
    for (const Tetrahedron& u : second) sum += sgn(six_volumes(t)) * sgn(six_volumes(u)) * common_six_volumes(t, u);
  return sum / 6;
}

// The rest compares.

/// Ids of two meshes together, in random order.
struct Ids {
  std::vector<uint32_t> a, b;
};
Ids any_ids(const Mesh& a, const Mesh& b, std::mt19937& random) {
  std::vector<uint32_t> all(a.p.size() + b.p.size());
  std::iota(all.begin(), all.end(), 0);
  std::shuffle(all.begin(), all.end(), random);
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(a.p.size());
  return {{all.begin(), middle}, {middle, all.end()}};
}

struct Found {
  double volume;
  bool have_common;
};
Found find(const Mesh& a, const Mesh& b, const Ids& ids) {
  const SolidMesh first{a.p, ids.a, a.triangles}, second{b.p, ids.b, b.triangles};
  return {overlap_volume(first, second), have_common_volume(first, second)};
}

/// Expects a volume within rounding, 0 for 0, whatever the ids and the order of the meshes.
void expect_volume(const Mesh& a, const Mesh& b, const mpq_class& volume, std::mt19937& random, int repeats = 1) {
  for (int i = 0; i < repeats; ++i) {
    const Ids ids = any_ids(a, b, random);
    for (const Found& f : {find(a, b, ids), find(b, a, {ids.b, ids.a})}) {
      ASSERT_LE(abs(mpq_class(f.volume) - volume), abs(volume) * 0x1p-50) << f.volume << ' ' << volume.get_d();
      ASSERT_EQ(f.have_common, volume > 0) << volume.get_d();
    }
  }
}
void expect_truth(const Mesh& a, const Mesh& b, std::mt19937& random, int repeats = 1) {
  expect_volume(a, b, volume_in_rationals(a, b), random, repeats);
}

struct Known {
  const char* name;
  Mesh a, b;
  mpq_class volume;
};
std::vector<Known> known() {
  const Mesh left = {{{0, 0, 0}, {1, 0, 1}, {1, 1, 0}, {0, 1, 1}}, kTetrahedron},
             right = {{{1, 1, 1}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}}, kTetrahedron};
  return {{"flush on a face", box({-3, -1, 0}, {-1, 1, 2}), box({-1, -1, 0}, {1, 1, 2}), 0},
          {"coplanar sides", box({-3, -1, 0}, {-0.875, 1, 2}), box({-1, -1, 0}, {1, 1, 2}), mpq_class(1, 2)},
          {"apart", box({-3, -1, 0}, {-1.1, 1, 2}), box({-1, -1, 0}, {1, 1, 2}), 0},
          {"equal", cube(0, 1), cube(0, 1), 1},
          {"stella octangula", left, right, mpq_class(1, 6)},
          {"inscribed", left, cube(0, 1), mpq_class(1, 3)},
          {"common corner", cube(0, 1), cube(1, 2), 0},
          {"common edge", cube(0, 1), box({1, 1, 0}, {2, 2, 1}), 0},
          {"nested", cube(0, 10), cube(4, 5), 1},
          {"cavity", together(cube(0, 10), reversed(cube(4, 6))), cube(3, 7), 56},
          {"in the cavity", together(cube(0, 4), reversed(cube(1, 3))), cube(1.5, 2), 0},
          {"fills the cavity", together(cube(0, 4), reversed(cube(1, 3))), cube(1, 3), 0},
          {"through the ends", box({-3, -1, -1}, {3, 1, 1}), box({-1, -3, 0.5}, {1, 3, 3}), 2},
          {"two in one", together(cube(0, 2), cube(1, 3)), cube(0, 3), 16},
          {"two in one, twice", together(cube(0, 2), cube(1, 3)), together(cube(0, 2), cube(1, 3)), 18},
          {"no area", {{{0, 0, 0}, {2, 0, 0}, {1, 0, 0}, {1, 0, 0}}, kTetrahedron}, cube(0, 2), 0},
          {"nothing", {}, cube(0, 2), 0}};
}

TEST(Overlap, OfKnownVolume) {
  std::mt19937 random(1);
  for (const Known& k : known()) {
    SCOPED_TRACE(k.name);
    EXPECT_EQ(volume_in_rationals(k.a, k.b), k.volume) << "the judge";
    expect_volume(k.a, k.b, k.volume, random, 20);
  }
  // The box ends at the double next to -0.9.
  const Mesh a = box({-3, -1, 0}, {-0.9, 1, 2}), b = box({-1, -1, 0}, {1, 1, 2});
  EXPECT_NEAR(find(a, b, any_ids(a, b, random)).volume, 0.4, 1e-15);
  expect_truth(a, b, random, 20);
}

TEST(Overlap, IsTheSameAnywhereInAnySize) {
  std::mt19937 random(2);
  for (const Known& k : known()) {
    SCOPED_TRACE(k.name);
    const auto far = [](const Point& p) { return p + Point{0x1p40, -0x1p40, 0x1p40}; };
    expect_volume(with_points(k.a, far), with_points(k.b, far), k.volume, random, 3);
    const auto small = [](const Point& p) { return 0x1p-300 * p; };
    expect_volume(with_points(k.a, small), with_points(k.b, small), k.volume / (mpz_class(1) << 900), random, 3);
    const auto tiny = [](const Point& p) { return 0x1p-1070 * p; };  // the volume is no double, but its sign is known
    const Mesh a = with_points(k.a, tiny), b = with_points(k.b, tiny);
    EXPECT_EQ(find(a, b, any_ids(a, b, random)).have_common, k.volume > 0);
  }
}

/// Returns a body with corners on a lattice: a tetrahedron with its outward side, or an octahedron that may run through
/// itself.
Mesh any_lattice_body(std::mt19937& random, int size, const Triangles& triangles) {
  std::uniform_int_distribution<int> coordinate(0, size - 1);
  for (;;) {
    Mesh mesh{{}, triangles};
    for (int i = 0; i < (triangles == kTetrahedron ? 4 : 6); ++i) {
      const double x = coordinate(random), y = coordinate(random);
      mesh.p.push_back({x, y, static_cast<double>(coordinate(random))});
    }
    if (triangles != kTetrahedron) return mesh;
    const mpq_class six =
        six_volumes({rational(mesh.p[0]), rational(mesh.p[1]), rational(mesh.p[2]), rational(mesh.p[3])});
    if (six > 0) return mesh;
    if (six < 0) return reversed(mesh);
  }
}

TEST(Overlap, OfLatticeTetrahedra) {
  std::mt19937 random(3);
  int common = 0, apart = 0;
  for (int i = 0; i < 2500; ++i) {
    const int size = i < 2000 ? 5 : 3;
    const Mesh a = any_lattice_body(random, size, kTetrahedron), b = any_lattice_body(random, size, kTetrahedron);
    const mpq_class volume = volume_in_rationals(a, b);
    ++(volume > 0 ? common : apart);
    expect_volume(a, b, volume, random);
    if (HasFailure()) return;
  }
  EXPECT_GT(common, 500);
  EXPECT_GT(apart, 500);
}

/// Bodies with windings from -1 to 2, triangles without area, vertices in one place and edges with four triangles.
TEST(Overlap, OfBodiesThatRunThroughThemselves) {
  std::mt19937 random(4);
  int negative = 0, positive = 0;
  for (int i = 0; i < 400; ++i) {
    Mesh a = any_lattice_body(random, 2 + i % 4, kOctahedron);
    const Mesh b = any_lattice_body(random, 2 + i % 4, i % 2 == 0 ? kOctahedron : kTetrahedron);
    if (i % 3 == 0) {  // a second body on the first one's edge 0 2
      Mesh other = any_lattice_body(random, 2 + i % 4, kTetrahedron);
      other.p[0] = a.p[0], other.p[1] = a.p[2];
      for (auto t : other.triangles) {
        for (uint32_t& v : t) v = v == 0 ? 0 : v == 1 ? 2 : v + 4;
        a.triangles.push_back(t);
      }
      a.p.push_back(other.p[2]), a.p.push_back(other.p[3]);
    }
    const mpq_class volume = volume_in_rationals(a, b);
    negative += volume<0, positive += volume> 0;
    expect_volume(a, b, volume, random);
    if (HasFailure()) return;
  }
  EXPECT_GT(negative, 30);
  EXPECT_GT(positive, 30);
}

TEST(Overlap, OfAnySize) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::uniform_int_distribution<int> exponent(-250, 250);
  for (int i = 0; i < 200; ++i) {
    const double unit = std::ldexp(1.0, exponent(random));
    const auto any_body = [&] {
      return with_points(any_lattice_body(random, 3, i % 4 == 0 ? kOctahedron : kTetrahedron), [&](Point p) {
        const double own = i % 8 == 1 ? std::ldexp(1.0, exponent(random) / 8) : 1;
        for (double* x : {&p.x, &p.y, &p.z})
          if (random() % 2 == 0) *x += uniform(random);
        return unit * own * p;
      });
    };
    const Mesh a = any_body(), b = any_body();
    const Ids ids = any_ids(a, b, random);
    const Found f = find(a, b, ids);
    const mpq_class volume = volume_in_rationals(a, b);
    ASSERT_EQ(f.have_common, volume > 0);
    const double truth = volume.get_d();
    ASSERT_NEAR(f.volume, truth, 0x1p-49 * std::fabs(truth));
  }
}

/// A slab whose upper side is a grid of n x n cells at height 0, turned by some angle around z.
Mesh grid_slab(uint32_t n, double angle, double depth) {
  Mesh mesh;
  const double c = std::cos(angle), s = std::sin(angle);
  for (const double z : {0.0, depth})
    for (uint32_t j = 0; j <= n; ++j)
      for (uint32_t i = 0; i <= n; ++i) {
        const double x = i - 0.5 * n, y = j - 0.5 * n;
        mesh.p.push_back({c * x - s * y, s * x + c * y, z});
      }
  const uint32_t row = n + 1, layer = row * row;
  const auto add = [&](uint32_t a, uint32_t b, uint32_t d, uint32_t e) {  // a b d e around the front
    mesh.triangles.push_back({a, b, d});
    mesh.triangles.push_back({a, d, e});
  };
  for (uint32_t j = 0; j < n; ++j)
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t a = j * row + i;
      add(a, a + 1, a + row + 1, a + row);
      add(layer + a, layer + a + row, layer + a + row + 1, layer + a + 1);
    }
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t last = n * row + i, left = i * row, right = left + n;
    add(i + 1, i, layer + i, layer + i + 1);
    add(last, last + 1, layer + last + 1, layer + last);
    add(left, left + row, layer + left + row, layer + left);
    add(right + row, right, layer + right, layer + right + row);
  }
  return depth < 0 ? mesh : reversed(mesh);
}

/// 10,000 triangles each, half of them in one plane.
TEST(Overlap, OfLargeFlushBodies) {
  std::mt19937 random(6);
  const Mesh lower = grid_slab(50, 0, -3), upper = grid_slab(50, 0.5, 3);
  const Ids ids = any_ids(lower, upper, random);
  EXPECT_EQ(find(lower, upper, ids).volume, 0);
  EXPECT_FALSE(find(lower, upper, ids).have_common);
  const auto sink = [](const Point& p) { return p + Point{0, 0, -0x1p-30}; };
  const Found f = find(lower, with_points(upper, sink), ids);
  EXPECT_TRUE(f.have_common);
  EXPECT_NEAR(f.volume * 0x1p30 / (50 * 50), 2 / (1 + std::sin(0.5) + std::cos(0.5)), 1e-6);
}

TEST(Overlap, OfSmallGrids) {
  std::mt19937 random(7);
  for (const double angle : {0.0, 0.5, M_PI_2})
    for (const double sinks : {-1.0, 0.0, 0.25}) {
      const auto sink = [&](const Point& p) { return p - Point{0, 0, sinks}; };
      expect_truth(grid_slab(2, 0, -3), with_points(grid_slab(2, angle, 3), sink), random, 3);
    }
}

// The judge of triangles.

using Corners = std::array<Point, 3>;
using Weights = std::array<mpq_class, 6>;

/// Solves for weights of a common point, where only the corners in the bit set `chosen` have any.
std::optional<Weights> common_point(const std::array<Vector, 6>& corners, unsigned chosen) {
  std::vector<size_t> columns;
  for (size_t i = 0; i < 6; ++i)
    if (chosen >> i & 1) columns.push_back(i);
  if (columns.size() > 5) return std::nullopt;
  FiveEquations m;
  for (size_t k = 0; k < columns.size(); ++k) {
    const size_t i = columns[k];
    for (size_t row = 0; row < 3; ++row) m[row][k] = i < 3 ? corners[i][row] : mpq_class(-corners[i][row]);
    m[i < 3 ? 3 : 4][k] = 1;
  }
  m[3][5] = m[4][5] = 1;
  const auto solution = only_solution(m, columns.size());
  if (!solution) return std::nullopt;
  Weights w;
  for (size_t k = 0; k < columns.size(); ++k) w[columns[k]] = (*solution)[k];
  return w;
}

/// The weights of all common points are a polytope. A weight is above 0 inside of it if it is at some corner of it.
bool share_inner_points(const std::array<Vector, 6>& corners) {
  unsigned above = 0;
  for (unsigned chosen = 1; chosen < 64; ++chosen) {
    const auto w = common_point(corners, chosen);
    if (!w || *std::min_element(w->begin(), w->end()) < 0) continue;
    for (size_t i = 0; i < 6; ++i)
      if ((*w)[i] > 0) above |= 1u << i;
  }
  return above == 63;
}
bool cross_in_rationals(const Corners& a, const Corners& b) {
  const std::array<Vector, 6> x = {rational(a[0]), rational(a[1]), rational(a[2]),
                                   rational(b[0]), rational(b[1]), rational(b[2])};
  const Vector across = cross_product(cross_product(x[1] - x[0], x[2] - x[0]), cross_product(x[4] - x[3], x[5] - x[3]));
  return across != Vector{} && share_inner_points(x);
}
bool cross(const Corners& a, const Corners& b) { return insides_cross({a[0], a[1], a[2]}, {b[0], b[1], b[2]}); }

void expect_truth(const Corners& a, const Corners& b, int (&counts)[2]) {
  const bool truth = cross_in_rationals(a, b);
  ++counts[truth];
  ASSERT_EQ(cross(a, b), truth);
  ASSERT_EQ(cross(b, a), truth);
  ASSERT_EQ(cross({a[2], a[1], a[0]}, {b[1], b[2], b[0]}), truth);
}

TEST(Insides, FullOfTies) {
  std::mt19937 random(8);
  int counts[2] = {};
  for (int i = 0; i < 4000; ++i) {
    std::uniform_int_distribution<int> coordinate(0, 1 + i % 4);
    Corners t[2];
    for (Corners& corners : t)
      for (Point& p : corners)
        for (double* x : {&p.x, &p.y, &p.z}) *x = coordinate(random);
    if (i % 5 == 0) t[1][0] = t[0][0];
    expect_truth(t[0], t[1], counts);
    if (HasFailure()) return;
  }
  for (const int count : counts) EXPECT_GT(count, 300);
}

TEST(Insides, OfAnySize) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::uniform_int_distribution<int> exponent(-300, 300);
  int counts[2] = {};
  for (int i = 0; i < 1500; ++i) {
    const double unit = std::ldexp(1.0, exponent(random));
    const Point offset = i % 3 == 0 ? Point{0x1p40, 0x1p40, -0x1p40} : Point{0, 0, 0};
    Corners t[2];
    for (Corners& corners : t)
      for (Point& p : corners) {
        for (double* x : {&p.x, &p.y, &p.z}) *x = uniform(random);
        p = unit * (p + offset);
      }
    if (i % 4 == 0) t[1][0] = 0.5 * (t[0][0] + t[0][1]);
    expect_truth(t[0], t[1], counts);
    if (HasFailure()) return;
  }
  for (const int count : counts) EXPECT_GT(count, 150);
}

TEST(Insides, ExtremeNumbers) {
  const double tiny = 0x1p-1074, large = 1e300;
  const Corners flat = {{{-large, -large, 0}, {large, -large, 0}, {0, large, 0}}};
  EXPECT_TRUE(cross(flat, {{{0, 0, -tiny}, {tiny, 0, tiny}, {0, tiny, tiny}}}));
  EXPECT_FALSE(cross(flat, {{{0, 0, 0}, {tiny, 0, tiny}, {0, tiny, tiny}}}));
  EXPECT_TRUE(cross(flat, {{{0, 0, -large}, {large, 0, tiny}, {0, tiny, tiny}}}));
}

}  // namespace
}  // namespace collided::test
