#include "gpu/positions/rigid_arc.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gpu/base/precision.hpp"

namespace collided {
namespace {

using Vec = Vec3<double>;

constexpr double kUnit = Precision<double>::kUnit;

double length(const Vec& v) { return std::sqrt(dot(v, v)); }

/// R to R of another pose: R1 - R0. Its columns are orthogonal to the axis, and their Frobenius norm is
/// 2 sqrt(2) sin(angle / 2).
struct Turn {
  Vec column[3];

  Turn(const Pose& from, const Pose& to) {
    const auto entry = [&](int i, int k) { return to.r(i, k) - from.r(i, k); };
    for (int k = 0; k < 3; ++k) column[k] = {entry(0, k), entry(1, k), entry(2, k)};
  }
  double sine_of_half() const {
    return std::sqrt((dot(column[0], column[0]) + dot(column[1], column[1]) + dot(column[2], column[2])) / 8);
  }
  /// The longest normal of two columns, which is never short: one of the three is 4 sin^2(angle / 2) / sqrt(3) at
  /// least, whatever the angle is.
  Vec axis() const {
    const Vec normals[] = {cross(column[1], column[2]), cross(column[2], column[0]), cross(column[0], column[1])};
    const Vec longest = *std::max_element(std::begin(normals), std::end(normals),
                                          [](const Vec& a, const Vec& b) { return dot(a, a) < dot(b, b); });
    return (1 / length(longest)) * longest;
  }
  Vec of(const Vec& p) const { return (p.x * column[0] + p.y * column[1]) + p.z * column[2]; }
};

Vec translation(const Pose& pose) { return {pose.t(0), pose.t(1), pose.t(2)}; }

Vec at(const Pose& p, const Vec& x) {
  const auto row = [&](int i) { return p.r(i, 0) * x.x + p.r(i, 1) * x.y + p.r(i, 2) * x.z + p.t(i); };
  return {row(0), row(1), row(2)};
}

/// Corners of a box; a norm of an affine function is nowhere larger than at one of them.
Vec corner_of(const Box<double>& box, int i) {
  return {i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y, i & 4 ? box.hi.z : box.lo.z};
}
template <class Size>
double largest_of_corners(const Box<double>& box, const Size& size) {
  double largest = 0;
  for (int i = 0; i < 8; ++i) largest = std::max(largest, size(corner_of(box, i)));
  return largest;
}

/// Holds bounds of the distance between screws and straight paths. They add up.
struct Deviation {
  double arc, rounding;  ///< of all computation but that to the format of positions
  double rounded;        ///< to that format, at both ends
  double bend, defect;

  double all() const { return (arc + rounding + rounded) * (1 + 0x1p-44); }
  double of_poses() const { return (arc + rounding) * (1 + 0x1p-44); }
};

// The deviation of a screw from straight paths.
//
// The motion that is bounded. Matrices of binary64 are rarely rotations, so the screw goes between poses [Q0 | s0] and
// [Q1 | s1] that the given ones are roundings of: rotations with |Ri - Qi| <= e in the Frobenius norm, and translations
// within u = 2^-53 of ti in each component. e is the defect of R and 2^-48. The nearest rotation is within 0.51 of the
// defect; 2^-48 = 32u covers the rounding of the defect itself and of a rotation's entries by the caller. The bound
// holds for all such poses. Q1 Q0^T turns by a in [0, pi] about the unit vector n.
//
// The arc. Let w be the chord of a vertex without its part along n. A vertex at distance r from the axis has
// |w| = 2 r sin(a/2). With b = a/2, its arc about the axis and the chord part at x in [-1, 1] by
//   f(x) = e^(ibx) - (cos b + i x sin b), times r.
// |f| is even. The derivative of |f|^2 has the sign of E(bx), where E(y) = sin(b)/b - (1 - b cot b) sin(y)/y - cos(y).
// As 1 - b cot b >= 0, E rises on [0, b], up to E(b) = 0. So |f| is largest at x = 0: the deviation is at most the
// sagitta r (1 - cos b) = |w| S / (2 (1 + sqrt(1 - S^2))), S = sin b. The factor of |w|, `bend`, rises with S and is at
// most S / 2.
//
// S. |Q1 - Q0| = 2 sqrt(2) S and R1 - R0 is within 2e of Q1 - Q0, so S is within 0.71e of `middle`. The rest of e
// covers the roundings of `middle`, below 9u.
//
// w. Q1 - Q0 maps into the plane across n, so w = (Q1 - Q0) p + s, s the slide s1 - s0 without its part along n. It is
// a sum of vectors and takes no difference of squares: sqrt(|chord|^2 - |advance|^2) would lose what is below 2^-26 of
// the slide. What R1 - R0 instead of Q1 - Q0 costs is 2e |p|.
// - The columns of Q1 - Q0 are across n. The normals of two of them are 4 S^2 times components of a unit vector, so the
//   longest has 2.3 S^2 at least. The columns are at most 2S long and known to within 2.1e together; so a normal is off
//   by at most 5.95 S e + 2.3 e^2, and for S >= 19e the sine of the angle between `axis` and n is at most 4 e / S. This
//   moves s by no more than that share of the slide. S is at least middle - e.
// - Below that, all of the slide is taken, which is more; `bend` is at most 11e there.
//
// Roundings, with |p| <= far, positions within reach, |ti| <= reach + 1.001 far:
// - Posed vertices are within e far of Qi p + ti, 5.3u far + u reach for the operations, `unit` reach for the format,
//   and u |ti| for what the translation was rounded from.
// - `chord`: 16u far, 24u of the slide, and 2u |ti|. `bend` halves them at least.
// Together: (e + 32u) far, which 2 e far covers, 4u reach, and 24u of the slide within `lost`. All that is added is
// positive, so that its own roundings are relative: 2^-44 covers them.
//
// In units in which the largest coordinate is near 1, so that squares neither overflow nor underflow.
Deviation scaled_deviation(const Pose& from, const Pose& to, const Box<double>& rest, double unit) {
  const Turn turn(from, to);
  const double far = largest_of_corners(rest, length);
  const double reach =
      largest_of_corners(rest, [&](const Vec& p) { return std::max(length(at(from, p)), length(at(to, p))); });
  const double defect = std::max(rotation_defect(from), rotation_defect(to)) + 0x1p-48;
  const double middle = turn.sine_of_half(), sine = std::min(1.0, middle + defect);
  const double bend = sine / (2 * (1 + std::sqrt((1 - sine) * (1 + sine))));

  const Vec slide = translation(to) - translation(from);
  Vec across = slide;
  double lost = 0;
  if (middle > 20 * defect) {
    const Vec axis = turn.axis();
    across = slide - dot(axis, slide) * axis;
    lost = 4 * defect / (middle - defect) + 24 * kUnit;
  }
  const double chord = largest_of_corners(rest, [&](const Vec& p) { return length(turn.of(p) + across); });
  const double arc = bend * (chord + 2 * defect * far + lost * length(slide));
  return {arc, 2 * defect * far + 8 * kUnit * reach, unit * reach, bend, defect};
}

/// The same in the units of the positions.
template <class Real>
Deviation deviation_between(const Pose& from, const Pose& to, const Box<double>& rest) {
  const double scale = unit_scale(std::max({largest_component(rest.lo), largest_component(rest.hi),
                                            largest_component(translation(from)), largest_component(translation(to))}));
  const auto scaled = [&](Pose pose) {
    for (size_t i = 3; i < pose.rows.size(); i += 4) pose.rows[i] *= scale;
    return pose;
  };
  const Deviation found =
      scaled_deviation(scaled(from), scaled(to), {scale * rest.lo, scale * rest.hi}, Precision<Real>::kUnit);
  constexpr double kLeast = std::numeric_limits<Real>::denorm_min();  // of which subnormal positions lose a few
  return {found.arc / scale, found.rounding / scale, found.rounded / scale + 8 * kLeast, found.bend, found.defect};
}

}  // namespace

double angle_between(const Pose& from, const Pose& to) {
  return 2 * std::asin(std::min(1.0, Turn(from, to).sine_of_half()));
}

double largest_coordinate(const Pose& pose, const Box<double>& rest) {
  return largest_of_corners(rest, [&](const Vec& x) { return largest_component(at(pose, x)); }) * (1 + 0x1p-48);
}

template <class Real>
double arc_deviation(const Pose& from, const Pose& to, const Box<double>& rest) {
  return from.has_rotation_of(to) ? 0 : deviation_between<Real>(from, to, rest).all();
}

template <class Real>
MeshTurn mesh_turn(const Pose& from, const Pose& to, const Box<double>& rest) {
  if (from.has_rotation_of(to)) return {};
  const Deviation found = deviation_between<Real>(from, to, rest);
  MeshTurn turn{
      found.of_poses(),   found.rounding * (1 + 0x1p-44), found.rounding + found.rounded, found.bend, found.defect,
      half_turn(from, to)};
  for (int i = 0; i < 3; ++i) {
    const auto entry = [&](int j) {
      return from.r(i, 0) * to.r(j, 0) + from.r(i, 1) * to.r(j, 1) + from.r(i, 2) * to.r(j, 2);
    };
    turn.back[i] = {entry(0), entry(1), entry(2)};
  }
  return turn;
}

template double arc_deviation<float>(const Pose&, const Pose&, const Box<double>&);
template double arc_deviation<double>(const Pose&, const Pose&, const Box<double>&);
template MeshTurn mesh_turn<float>(const Pose&, const Pose&, const Box<double>&);
template MeshTurn mesh_turn<double>(const Pose&, const Pose&, const Box<double>&);

}  // namespace collided
