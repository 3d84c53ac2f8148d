#pragma once
// A screw in 67 digits: the judge of what the engine allows for arcs. It shares no code with the engine but the type of
// a pose.

#include <gmpxx.h>

#include <array>

#include "gpu/positions/pose.hpp"
#include "tests/support/case.hpp"

namespace collided::test {

using Exact = mpf_class;
using ExactVec = std::array<Exact, 3>;

inline Exact exact(double x) { return Exact(x, 224); }
ExactVec exact(const Vec3d& v);
ExactVec operator+(const ExactVec& a, const ExactVec& b);
ExactVec operator-(const ExactVec& a, const ExactVec& b);
ExactVec operator*(const Exact& s, const ExactVec& a);
Exact dot(const ExactVec& a, const ExactVec& b);
ExactVec cross(const ExactVec& a, const ExactVec& b);
Exact length(const ExactVec& a);
ExactVec unit(const ExactVec& a);
/// The nearest double, or the one next to it.
double nearest(const Exact& x);
Vec3d nearest(const ExactVec& a);

struct Angle {
  Exact sine, cosine;
  /// By the power series.
  explicit Angle(const Exact& radians);
};
ExactVec turned(const ExactVec& v, const ExactVec& axis, const Angle& angle);

/// A mesh is posed, and from there moves along a screw.
struct ExactScrew {
  ExactVec posed_about = exact(Vec3d{0, 0, 1});  ///< unit vector
  Exact posed_by = exact(0);
  ExactVec posed_at = exact(Vec3d{0, 0, 0});
  ExactVec axis = exact(Vec3d{0, 0, 1});    ///< unit vector
  ExactVec centre = exact(Vec3d{0, 0, 0});  ///< a point of the axis
  Exact angle = exact(0), slide = exact(0);

  /// What a direction at rest is at t = 0.
  ExactVec direction(const ExactVec& v) const { return turned(v, posed_about, Angle(posed_by)); }
  /// After a part of the motion, from 0 to 1: p -> R p + t.
  struct Moment {
    std::array<ExactVec, 3> columns;  ///< of R
    ExactVec t;

    ExactVec operator()(const ExactVec& p) const;
    /// Rounded to doubles. R is stretched by 1 + stretch along each axis at rest, so that it is no rotation.
    Pose pose(const Vec3d& stretch = {0, 0, 0}) const;
  };
  Moment at(double t) const;
};

/// x rounded to a format of positions. Vectorized by GCC 12, a cast to float and back would round nothing.
template <class Real>
double rounded_to(double x) {
  volatile Real narrow = static_cast<Real>(x);
  return narrow;
}

/// Where CONVENTIONS.md says that a pose puts a vertex.
template <class Real>
Vec3d posed_by(const Pose& pose, const Vec3d& p) {
  Vec3d out;
  for (size_t i = 0; i < 3; ++i) {
    const double* row = &pose.rows[4 * i];
    double sum = row[0] * p[0];
    const double second = row[1] * p[1], third = row[2] * p[2];
    sum += second;
    sum += third;
    sum += row[3];
    out[i] = rounded_to<Real>(sum);
  }
  return out;
}

}  // namespace collided::test
