#include "tests/support/judge/exact_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

namespace collided::test {
namespace {

// value = digits * 2^exponent
struct Binary {
  int64_t digits = 0;
  int exponent = std::numeric_limits<int>::max();
};

Binary binary(double value) {
  if (!std::isfinite(value)) throw std::invalid_argument("exact judge: a number is not finite");
  if (value == 0) return {};
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  return {static_cast<int64_t>(std::ldexp(mantissa, 53)), exponent - 53};
}

mpz_class integer(const Binary& b, int lowest) {
  if (b.digits == 0) return 0;
  mpz_class z;
  mpz_set_si(z.get_mpz_t(), static_cast<long>(b.digits));
  return z << static_cast<mp_bitcnt_t>(b.exponent - lowest);
}

constexpr VertexEdge kVertexOnTriangle[] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
constexpr VertexEdge kEndOnEdge[] = {{0, 2, 3}, {1, 2, 3}, {2, 0, 1}, {3, 0, 1}};

int points_of_first(QueryKind kind) { return kind == QueryKind::kVertexTriangle ? 1 : 2; }

std::vector<Polynomial> inside_triangle(const ExactQuery& q, const PolynomialVector& n) {
  const PolynomialVector a = q.x[1] - q.x[0], b = q.x[2] - q.x[0], c = q.x[3] - q.x[0];
  return {dot(cross(b, c), n), dot(cross(c, a), n), dot(cross(a, b), n)};
}

// The feet are at the fractions u / |n|^2 and v / |n|^2 of the two edges.
std::vector<Polynomial> inside_edges(const ExactQuery& q, const PolynomialVector& n) {
  const PolynomialVector between = q.x[2] - q.x[0];
  const Polynomial u = dot(cross(between, q.x[3] - q.x[2]), n);
  const Polynomial v = dot(cross(between, q.x[1] - q.x[0]), n);
  const Polynomial one = dot(n, n);
  return {u, one - u, v, one - v};
}

}  // namespace

ExactQuery exact_query(const Query& query, const Thickness& thickness) {
  int lowest = std::numeric_limits<int>::max();
  for (const double part : thickness.parts) {
    if (part < 0) throw std::invalid_argument("exact judge: the thickness is negative");
    lowest = std::min(lowest, binary(part).exponent);
  }
  std::array<std::array<Binary, 3>, 8> coordinates;
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 3; ++k) {
      coordinates[i][k] = binary(query.p[i][k]);
      lowest = std::min(lowest, coordinates[i][k].exponent);
    }
  ExactQuery q{query.kind, {}, 0};
  for (const double part : thickness.parts) q.thickness += integer(binary(part), lowest);
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) {
      std::vector<mpz_class> c(2);
      c[0] = integer(coordinates[i][k], lowest);
      c[1] = integer(coordinates[i + 4][k], lowest) - c[0];
      q.x[i][k] = Polynomial(std::move(c));
    }
  return q;
}

Query standing(QueryKind kind, const std::array<Vec3d, 4>& p) {
  return {kind, {p[0], p[1], p[2], p[3], p[0], p[1], p[2], p[3]}};
}

PolynomialVector normal_of(const ExactQuery& q) {
  if (q.kind == QueryKind::kVertexTriangle) return cross(q.x[2] - q.x[1], q.x[3] - q.x[1]);
  return cross(q.x[1] - q.x[0], q.x[3] - q.x[2]);
}

Polynomial coplanarity(const ExactQuery& q, const PolynomialVector& normal) {
  return dot(normal, q.kind == QueryKind::kVertexTriangle ? q.x[0] - q.x[1] : q.x[2] - q.x[0]);
}

Interior interior_of(const ExactQuery& q) {
  const PolynomialVector n = normal_of(q);
  return {coplanarity(q, n), n, q.kind == QueryKind::kVertexTriangle ? inside_triangle(q, n) : inside_edges(q, n)};
}

std::span<const VertexEdge> vertex_edges(QueryKind kind) {
  if (kind == QueryKind::kVertexTriangle) return kVertexOnTriangle;
  return kEndOnEdge;
}

bool apart_along_an_axis(const ExactQuery& q) {
  const Polynomial width{q.thickness};
  const int n = points_of_first(q.kind);
  const auto apart = [&](int axis, bool ascending) {
    for (int i = 0; i < n; ++i)
      for (int j = n; j < 4; ++j) {
        const Polynomial &first = q.x[ascending ? i : j][axis], &second = q.x[ascending ? j : i][axis];
        const Polynomial gap = second - first - width;
        if (gap.sign_at_zero() <= 0 || gap.sign_at_one() <= 0) return false;
      }
    return true;
  };
  for (int axis = 0; axis < 3; ++axis)
    if (apart(axis, true) || apart(axis, false)) return true;
  return false;
}

bool apart_along_an_axis(const Query& query) {
  const int n = points_of_first(query.kind);
  const auto below = [&](int axis, int time, int first, int first_end, int second, int second_end) {
    for (int i = first; i < first_end; ++i)
      for (int j = second; j < second_end; ++j)
        if (!(query.p[time + i][axis] < query.p[time + j][axis])) return false;
    return true;
  };
  for (int axis = 0; axis < 3; ++axis)
    if ((below(axis, 0, 0, n, n, 4) && below(axis, 4, 0, n, n, 4)) ||
        (below(axis, 0, n, 4, 0, n) && below(axis, 4, n, 4, 0, n)))
      return true;
  return false;
}

}  // namespace collided::test
