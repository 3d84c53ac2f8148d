#include "gpu/exact/integers.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace collided::exact {
namespace {

/// x = odd * 2^exponent, or 0.
struct Binary {
  int64_t odd = 0;
  int exponent = 0;
};

Binary to_binary(double x) {
  if (x == 0) return {};
  int exponent = 0;
  int64_t odd = static_cast<int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
  const int zeros = std::countr_zero(static_cast<uint64_t>(odd));
  return {odd / (int64_t{1} << zeros), exponent - 53 + zeros};
}

template <class X>
Form form(const Unit& unit, const X& x) {
  return {{unit(x)}};
}
template <class X>
Form form(const Unit& unit, const X& start, const X& end) {
  return {{unit(start), unit(end)}};
}

}  // namespace

void Unit::see(double x) {
  if (x != 0) exponent_ = std::min(exponent_, to_binary(x).exponent);
}
Number Unit::operator()(double x) const {
  const Binary b = to_binary(x);
  return b.odd == 0 ? Number() : Number(b.odd) << static_cast<mp_bitcnt_t>(b.exponent - exponent_);
}
Number Unit::operator()(const ContactDistance& x) const {
  Number sum = (*this)(x.thickness);
  sum += (*this)(x.first);
  sum += (*this)(x.second);
  return sum;
}

ExactQuery at_rest(const Vec3<double> (&points)[4], const ContactDistance& limit) {
  Unit unit;
  unit.see(limit);
  unit.see(points);
  ExactQuery query{{}, form(unit, limit)};
  for (size_t i = 0; i < 4; ++i) {
    const Vec3<double>& p = points[i];
    query.points[i] = {form(unit, p.x), form(unit, p.y), form(unit, p.z)};
  }
  return query;
}

ExactQuery in_motion(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], const ContactDistance& limit) {
  Unit unit;
  unit.see(limit);
  unit.see(start);
  unit.see(end);
  ExactQuery query{{}, form(unit, limit, limit)};
  for (size_t i = 0; i < 4; ++i) {
    const Vec3<double>&p = start[i], &q = end[i];
    query.points[i] = {form(unit, p.x, q.x), form(unit, p.y, q.y), form(unit, p.z, q.z)};
  }
  return query;
}

std::vector<Vec3<Number>> integers(std::span<const Vec3<double>> points) {
  Unit unit;
  unit.see(points);
  std::vector<Vec3<Number>> result;
  for (const Vec3<double>& p : points) result.push_back(unit(p));
  return result;
}

}  // namespace collided::exact
