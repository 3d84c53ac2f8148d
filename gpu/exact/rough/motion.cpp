#include "gpu/exact/rough/motion.hpp"

#include <algorithm>
#include <cmath>

namespace collided::exact {
namespace {

using Axis = RoughMotion::Axis;

/// Returns what may be taken from all of an axis' coordinates: one of them if no difference is rounded, else 0.
double common_origin(const double (&at)[4]) {
  for (const double x : at) {
    // What the difference leaves out (Knuth's sum of two numbers).
    const long double a = x, b = -static_cast<long double>(at[0]), sum = a + b, of_b = sum - a;
    if ((a - (sum - of_b)) + (b - of_b) != 0) return 0;
  }
  return at[0];
}

Axis axis_of(const double (&at)[4]) {
  const long double origin = common_origin(at);
  Axis axis;
  for (size_t i = 0; i < 4; ++i) {
    axis.at[i] = rough(at[i] - origin);
    for (size_t j = 0; j < 4; ++j) axis.difference[i][j] = rough(static_cast<long double>(at[i]) - at[j]);
  }
  return axis;
}

RoughMotion::End end_of(const Vec3<double> (&p)[4], double s, double t, const ContactDistance& limit) {
  return {rough(s),
          rough(t),
          rough(limit.thickness) + rough(limit.first) + rough(limit.second),
          {axis_of({p[0].x, p[1].x, p[2].x, p[3].x}), axis_of({p[0].y, p[1].y, p[2].y, p[3].y}),
           axis_of({p[0].z, p[1].z, p[2].z, p[3].z})}};
}

/// Products of six such numbers are in the range of long double.
bool is_ordinary(const RoughNumber& x) { return x.size == 0 || (x.size > 0x1p-2700L && x.size < 0x1p2700L); }
bool is_ordinary(const Axis& axis) {
  return std::all_of(axis.at.begin(), axis.at.end(), [](const RoughNumber& x) { return is_ordinary(x); }) &&
         std::all_of(axis.difference.begin(), axis.difference.end(), [](const auto& row) {
           return std::all_of(row.begin(), row.end(), [](const RoughNumber& x) { return is_ordinary(x); });
         });
}

/// Known to be above 0 or below it, and well.
bool is_known(const RoughNumber& x) { return x.size != 0 && magnitude(x.value) >= kKnownShare * x.size; }

RoughNumber scaled(const RoughNumber& x, int exponent) {
  return {std::ldexp(x.value, exponent), std::ldexp(x.size, exponent)};
}

}  // namespace

RoughMotion::RoughMotion(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], const ContactDistance& limit)
    : ends_{end_of(start, 1, 0, limit), end_of(end, 0, 1, limit)} {}

double RoughMotion::ratio_at(const RoughForm::Place& place) const {
  constexpr int64_t kFar = 12000;
  const long double x =
      std::ldexp(static_cast<long double>(place.y), static_cast<int>(std::clamp<int64_t>(place.scale, -kFar, kFar)));
  const long double s = ends_[0].s.value + x * ends_[1].s.value, t = ends_[0].t.value + x * ends_[1].t.value;
  return static_cast<double>(std::clamp(t / s, 0x1p-500L, 0x1p500L));
}

// The difference q of two coordinates changes its sign where s : t = |q1| : |q0|. There, the positions times
// |q0| + |q1| are |q1| p0 + |q0| p1, of coordinates with terms that do not cancel. But the two coordinates are
// (i0 - j0) i1 - (i1 - j1) i0 = i0 j1 - i1 j0, but for the sign, in which terms of the sum have cancelled.
std::optional<RoughMotion::End> RoughMotion::meeting(size_t axis, size_t i, size_t j) const {
  const RoughNumber q0 = ends_[0].axes[axis].difference[i][j], q1 = ends_[1].axes[axis].difference[i][j];
  if (!is_known(q0) || !is_known(q1) || (q0.value > 0) == (q1.value > 0)) return std::nullopt;
  const int exponent = -std::ilogb(std::max(magnitude(q0.value), magnitude(q1.value)));
  const bool is_rising = q1.value > 0;
  const RoughNumber from = scaled(is_rising ? q1 : -q1, exponent), to = scaled(is_rising ? -q0 : q0, exponent);
  const auto combined = [&](const RoughNumber& a, const RoughNumber& b) { return from * a + to * b; };
  const auto &start = ends_[0], &end = ends_[1];
  End at{combined(start.s, end.s), combined(start.t, end.t), combined(start.limit, end.limit), {}};
  for (size_t k = 0; k < 3; ++k)
    for (size_t a = 0; a < 4; ++a) {
      at.axes[k].at[a] = combined(start.axes[k].at[a], end.axes[k].at[a]);
      for (size_t b = 0; b < 4; ++b)
        at.axes[k].difference[a][b] = combined(start.axes[k].difference[a][b], end.axes[k].difference[a][b]);
    }
  const std::array<RoughNumber, 4>&p = start.axes[axis].at, &q = end.axes[axis].at;
  const RoughNumber both = scaled(p[j] * q[i] - p[i] * q[j], exponent), equal = is_rising ? both : -both;
  Axis& met = at.axes[axis];
  met.at[i] = met.at[j] = equal;
  for (const size_t a : {i, j})
    for (size_t b = 0; b < 4; ++b) {
      met.difference[a][b] = b == i || b == j ? RoughNumber{} : equal - met.at[b];
      met.difference[b][a] = -met.difference[a][b];
    }
  if (!is_ordinary(at.s) || !is_ordinary(at.t) || !is_ordinary(at.limit) ||
      !std::all_of(at.axes.begin(), at.axes.end(), [](const Axis& a) { return is_ordinary(a); }))
    return std::nullopt;
  return at;
}

std::optional<std::array<RoughMotion, 2>> RoughMotion::cut(const RoughForm::Place& from,
                                                           const RoughForm::Place& to) const {
  const auto is_within = [&](long double x) {
    const auto at = [](const RoughForm::Place& p, long double by) {
      return std::ldexp(p.y * by, static_cast<int>(std::clamp<int64_t>(p.scale, -16000, 16000)));
    };
    return x >= at(from, 1 - 0x1p-30L) && x <= at(to, 1 + 0x1p-30L);
  };
  for (size_t axis = 0; axis < 3; ++axis)
    for (size_t i = 0; i < 4; ++i)
      for (size_t j = i + 1; j < 4; ++j) {
        const RoughNumber &q0 = ends_[0].axes[axis].difference[i][j], &q1 = ends_[1].axes[axis].difference[i][j];
        if (q1.value == 0 || !is_within(-q0.value / q1.value)) continue;
        if (const std::optional<End> at = meeting(axis, i, j))
          return std::array{RoughMotion(ends_[0], *at), RoughMotion(*at, ends_[1])};
      }
  return std::nullopt;
}

}  // namespace collided::exact
