#pragma once
// Doubles as integers: all of a query's numbers times one power of two. The decisions do not depend on the unit.

#include <array>
#include <climits>
#include <span>
#include <vector>

#include "gpu/base/contact_distance.hpp"
#include "gpu/base/vec3.hpp"
#include "gpu/exact/fixed/orientation.hpp"
#include "gpu/exact/form.hpp"

namespace collided::exact {

/// A query's numbers as forms of one degree: 0 at rest, 1 in motion.
template <class Linear>
struct QueryOf {
  std::array<Vec3<Linear>, 4> points;
  Linear limit;  ///< the contact distance
};
using ExactQuery = QueryOf<Form>;

ExactQuery at_rest(const Vec3<double> (&points)[4], const ContactDistance& limit);
ExactQuery in_motion(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], const ContactDistance& limit);

/// The unit in which all numbers seen are integers: the smallest exponent of theirs.
class Unit {
 public:
  void see(double x);
  void see(const Vec3<double>& p) { see(p.x), see(p.y), see(p.z); }
  void see(std::span<const Vec3<double>> points) {
    for (const Vec3<double>& p : points) see(p);
  }
  void see(const ContactDistance& x) { see(x.thickness), see(x.first), see(x.second); }
  /// Converts numbers that were seen.
  Number operator()(double x) const;
  Number operator()(const ContactDistance& x) const;
  /// The unit is 2^exponent, if a number other than 0 was seen.
  int exponent() const { return exponent_; }
  Vec3<Number> operator()(const Vec3<double>& p) const { return {(*this)(p.x), (*this)(p.y), (*this)(p.z)}; }

 private:
  int exponent_ = INT_MAX;
};

/// Returns the points in one unit, in which all coordinates are integers.
std::vector<Vec3<Number>> integers(std::span<const Vec3<double>> points);

/// Calls use(p) with the points as integers, `const Vec3<Int>* p`. Int is of fixed size where they fit, else Number.
template <int n, class Use>
void with_integers(const Vec3<double> (&points)[n], const Use& use) {
  if (!fixed::with_fixed_integers(points, use)) use(static_cast<const Vec3<Number>*>(integers(points).data()));
}

}  // namespace collided::exact
