#pragma once
// How far a vertex is from a triangle: first with a bound in double precision, then in numbers of twice that precision.
// All is relative to the vertex, and scaled so that no coordinate exceeds 4.

#include "gpu/base/twofold.hpp"
#include "gpu/narrow/distance.hpp"
#include "gpu/narrow/surfaces.hpp"

namespace collided {

/// Holds a squared distance that is off by at most `error`.
struct RoughDistance {
  double squared, error;
};

/// Returns the squared distance of the origin from triangle a b c.
///
/// Closest points of a border are within a few units of the last place, and an error e in the place of a closest point
/// adds e^2 to the squared distance. The height over the face is off by no more than S (1 + k) 2^-49, where S is the
/// largest distance of a corner and k = |ab| |ac| / |ab x ac|. Above k = 2^26 the face is so narrow that its border is
/// within 2 S / k of all its points.
COLLIDED_HD inline RoughDistance rough_distance(const Vec3<double> (&t)[3]) {
  const Vec3<double> zero{0, 0, 0}, ab = t[1] - t[0], ac = t[2] - t[0], n = cross(ab, ac);
  const double size = max(dot(t[0], t[0]), max(dot(t[1], t[1]), dot(t[2], t[2])));
  const double n2 = dot(n, n), sides = dot(ab, ab) * dot(ac, ac);
  if (!(n2 * 0x1p52 > sides)) return {closest_on_border(zero, t[0], t[1], t[2]).squared, 0x1p-20 * size + 0x1p-900};
  const double narrowness = square_root(sides / n2);
  return {closest_vertex_triangle(zero, t[0], t[1], t[2]).squared, (0x1p-44 + 0x1p-46 * narrowness) * size + 0x1p-900};
}

/// Holds a triangle as the vertex at the origin sees it.
struct SeenTriangle {
  Vec3<Twofold> corner[3];
  Vec3<Twofold> side[3];  ///< from corner k to the next

  COLLIDED_HD SeenTriangle(const Vec3<double>& from, const Vec3<double> (&t)[3], double scale) {
    for (int k = 0; k < 3; ++k) {
      corner[k] = scaled(exact_difference(t[k], from), scale);
      side[k] = scaled(exact_difference(t[(k + 1) % 3], t[k]), scale);
    }
  }
};

/// Holds how far the origin is from a triangle, and where the closest point is.
struct PreciseDistance {
  double squared = 0, error = 0;  ///< of the sum of `squared` and `low`
  double low = 0;
  double w0 = 0, w1 = 0;  ///< weights of the second and third corner
  Vec3<double> toward{};  ///< the direction to that point, near 1 in length or shorter
  int corners = 0;        ///< a bit for each corner that the point's feature has; 0: not certain

  /// Returns -1 if this is less than `other`, 1 if it is more, 0 if the errors leave it open.
  COLLIDED_HD int compare(const PreciseDistance& other) const {
    const double difference = (squared - other.squared) + (low - other.low), errors = error + other.error;
    return difference > errors ? 1 : difference < -errors ? -1 : 0;
  }
};

namespace detail {

COLLIDED_HD inline double value_of(const Twofold& x) { return x.high + x.low; }
COLLIDED_HD inline Twofold quotient(const Twofold& a, const Twofold& b) {
  const double first = a.high / b.high;
  const Twofold rest = a - Twofold{first, 0} * b;
  return exact_sum(first, rest.high / b.high);
}
COLLIDED_HD inline double length_of(const Vec3<Twofold>& v) {
  const Vec3<double> r = rounded(v);
  return square_root(dot(r, r));
}

/// Keeps the closest point of side k if it is nearer.
COLLIDED_HD COLLIDED_CALLED inline void keep_nearer_side(const SeenTriangle& t, int k, PreciseDistance& best) {
  const Vec3<Twofold>&a = t.corner[k], &b = t.corner[(k + 1) % 3], &ab = t.side[k];
  const Twofold along = -dot(a, ab), length = dot(ab, ab);
  const bool is_before = along.high <= 0, is_behind = !is_before && value_of(along - length) >= 0;
  PreciseDistance found;
  Twofold squared;
  double weight = 0;  // of b
  if (is_before || is_behind) {
    const Vec3<Twofold>& end = is_before ? a : b;
    squared = dot(end, end);
    found.toward = rounded(end);
    weight = is_before ? 0 : 1;
    found.corners = 1 << (is_before ? k : (k + 1) % 3);
  } else {
    const Vec3<Twofold> across = cross(ab, a);
    squared = quotient(dot(across, across), length);
    const Vec3<double> foot = rounded(cross(across, ab));  // |ab|^2 times the point's place
    found.toward = (1 / length.high) * foot;
    weight = min(value_of(along) / value_of(length), 1.0);
    found.corners = 1 << k | 1 << (k + 1) % 3;
  }
  found.squared = squared.high, found.low = squared.low;
  if (best.error > 0 && found.squared - best.squared + (found.low - best.low) >= 0) return;
  const double of[3] = {k == 0   ? 1 - weight
                        : k == 2 ? weight
                                 : 0,
                        k == 1   ? 1 - weight
                        : k == 0 ? weight
                                 : 0,
                        k == 2   ? 1 - weight
                        : k == 1 ? weight
                                 : 0};
  found.w0 = of[1], found.w1 = of[2];
  found.error = 0x1p-84;
  best = found;
}

}  // namespace detail

/// Returns how far the origin is from a triangle. With u = 2^-106, numbers of twice the precision are off by a few u of
/// the magnitudes that they are made of; every error here is many times that.
COLLIDED_HD inline PreciseDistance precise_distance(const SeenTriangle& t) {
  const Vec3<Twofold>& ab = t.side[0];
  const Vec3<Twofold> ac = {-t.side[2].x, -t.side[2].y, -t.side[2].z}, n = cross(ab, ac);
  const Twofold n2 = dot(n, n);
  const Vec3<Twofold>&a = t.corner[0], &b = t.corner[1], &c = t.corner[2];
  // n times the weight of each corner: of the triangle that the foot makes with the opposite side.
  const Twofold weights[3] = {dot(cross(b, c), n), dot(cross(c, a), n), dot(cross(a, b), n)};
  const double of_sides = detail::length_of(ab) * detail::length_of(ac);
  const double size = max(detail::length_of(a), max(detail::length_of(b), detail::length_of(c)));
  const double doubt = 0x1p-92 * size * size * of_sides;
  bool is_above = n2.high > 0, is_certain = true;
  for (const Twofold& weight : weights) {
    if (!(weight.high > doubt)) is_above = false;
    if (!(magnitude(weight.high) > doubt)) is_certain = false;
  }
  PreciseDistance best;
  if (is_above) {
    const Twofold height = dot(a, n), squared = detail::quotient(height * height, n2);
    best.squared = squared.high, best.low = squared.low;
    best.error = 0x1p-86 * (1 + of_sides / square_root(n2.high));
    best.w0 = weights[1].high / n2.high, best.w1 = min(weights[2].high / n2.high, 1 - best.w0);
    const Vec3<double> direction = brought_near_1(rounded(n));
    best.toward = height.high < 0 ? -1.0 * direction : direction;
    best.corners = 7;
    return best;
  }
  for (int k = 0; k < 3; ++k) detail::keep_nearer_side(t, k, best);
  if (!is_certain) best.corners = 0;
  return best;
}

}  // namespace collided
