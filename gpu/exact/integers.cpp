#include "gpu/exact/integers.hpp"

#include <algorithm>
#include <bit>
#include <climits>
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

/// The unit in which all numbers seen are integers: the smallest exponent of theirs.
class Unit {
 public:
  void see(double x) {
    if (x != 0) exponent_ = std::min(exponent_, to_binary(x).exponent);
  }
  void see(const Vec3<double> (&points)[4]) {
    for (const Vec3<double>& p : points)
      for (const double x : {p.x, p.y, p.z}) see(x);
  }
  void see(const ContactDistance& x) {
    for (const double part : {x.thickness, x.first, x.second}) see(part);
  }
  Number operator()(double x) const {
    const Binary b = to_binary(x);
    return b.odd == 0 ? Number() : Number(b.odd) << static_cast<mp_bitcnt_t>(b.exponent - exponent_);
  }
  Number operator()(const ContactDistance& x) const {
    Number sum = (*this)(x.thickness);
    sum += (*this)(x.first);
    sum += (*this)(x.second);
    return sum;
  }

 private:
  int exponent_ = INT_MAX;
};

template <class X>
Form form(const Unit& unit, const X& x) {
  return {{unit(x)}};
}
template <class X>
Form form(const Unit& unit, const X& start, const X& end) {
  return {{unit(start), unit(end)}};
}

}  // namespace

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

}  // namespace collided::exact
