#pragma once
// Four points that move linearly, as rough numbers, and the same on a part of their way.
//
// Where exponents lie far apart, a coordinate of one point passes those of others at times that no double tells from
// each other. A way that is cut at one of these times shows the others: there, two coordinates are equal for certain,
// and what is small beside them counts.

#include <array>
#include <optional>

#include "gpu/base/contact_distance.hpp"
#include "gpu/exact/roots/rough.hpp"
#include "gpu/exact/rough/polynomial.hpp"

namespace collided::exact {

class RoughMotion {
 public:
  /// Coordinates along an axis at one end, and their differences. Differences are known to their last bits, while
  /// coordinates have terms that differences drop.
  struct Axis {
    std::array<RoughNumber, 4> at;
    std::array<std::array<RoughNumber, 4>, 4> difference;  ///< of one point from another

    bool are_equal(size_t i, size_t j) const { return difference[i][j].size == 0; }
  };
  struct End {
    RoughNumber s, t, limit;  ///< s and t: of the whole way, times a number; limit: the contact distance
    std::array<Axis, 3> axes;
  };

  /// The whole way.
  RoughMotion(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], const ContactDistance& limit);

  const End& end(int i) const { return ends_[static_cast<size_t>(i)]; }
  /// t / s of the whole way at a place of this one.
  double ratio_at(const RoughForm::Place& place) const;
  /// Both parts of the way, cut where two coordinates become equal between two places; none if there are no such ones.
  std::optional<std::array<RoughMotion, 2>> cut(const RoughForm::Place& from, const RoughForm::Place& to) const;

 private:
  RoughMotion(const End& start, const End& end) : ends_{start, end} {}

  std::optional<End> meeting(size_t axis, size_t i, size_t j) const;

  std::array<End, 2> ends_;
};

}  // namespace collided::exact
