#pragma once
// Which points, segments and triangles meet, where they are nearest, and which convex bodies have a volume in common.
// All of it follows from signs of integers. Features may be degenerate.

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include "tests/gpu/solids/exact_vectors.hpp"

namespace collided::test {

template <class N>
bool is_on_segment(const Vector<N>& p, const Vector<N>& a, const Vector<N>& b) {
  const Vector<N> to_a = a - p, to_b = b - p;
  return is_zero(cross(to_a, to_b)) && sign(dot(to_a, to_b)) <= 0;
}

template <class N>
bool is_on_triangle(const Vector<N>& p, const Triangle<N>& triangle) {
  const Triangle<N> t = triangle.from(p);
  const Vector<N> n = t.normal();
  if (is_zero(n)) {
    for (const auto& [u, v] : t.sides())
      if (is_on_segment<N>({}, u, v)) return true;
    return false;
  }
  if (sign(dot(t.a, n)) != 0) return false;
  for (const auto& [u, v] : t.sides())
    if (sign(dot(n, cross(u, v))) < 0) return false;
  return true;
}

template <class N>
bool segments_meet(const Vector<N>& p, const Vector<N>& q, const Vector<N>& r, const Vector<N>& s) {
  const Vector<N> d = q - p, e = s - r, across = r - p, m = cross(d, e);
  if (is_zero(m))
    return is_on_segment(p, r, s) || is_on_segment(q, r, s) || is_on_segment(r, p, q) || is_on_segment(s, p, q);
  if (sign(dot(across, m)) != 0) return false;
  const N along_d = dot(cross(across, e), m), along_e = dot(cross(across, d), m), whole = dot(m, m);
  return sign(along_d) >= 0 && along_d <= whole && sign(along_e) >= 0 && along_e <= whole;
}

/// How a segment passes the sides of a triangle whose plane it crosses: 1 within, 0 on the border, -1 outside.
template <class N>
int place_of_passage(const Vector<N>& p, const Vector<N>& q, const Triangle<N>& triangle) {
  const Triangle<N> t = triangle.from(p);
  const Vector<N> d = q - p;
  int least = 1, greatest = -1;
  for (const auto& [u, v] : t.sides()) {
    const int side = sign(dot(d, cross(u, v)));
    least = std::min(least, side), greatest = std::max(greatest, side);
  }
  if (least < 0 && greatest > 0) return -1;
  return least > 0 || greatest < 0 ? 1 : 0;
}

/// True if a point between the ends is inside the triangle, and the segment is not in the triangle's plane.
template <class N>
bool goes_through(const Vector<N>& p, const Vector<N>& q, const Triangle<N>& triangle) {
  const Vector<N> n = triangle.normal();
  if (sign(dot(n, p - triangle.a)) * sign(dot(n, q - triangle.a)) >= 0) return false;
  return place_of_passage(p, q, triangle) > 0;
}

template <class N>
bool segment_meets(const Vector<N>& p, const Vector<N>& q, const Triangle<N>& triangle) {
  const Vector<N> n = triangle.normal();
  const int from = sign(dot(n, p - triangle.a)), to = sign(dot(n, q - triangle.a));
  if (!is_zero(n) && from * to > 0) return false;
  if (!is_zero(n) && (from != 0 || to != 0)) return place_of_passage(p, q, triangle) >= 0;
  if (is_on_triangle(p, triangle) || is_on_triangle(q, triangle)) return true;
  for (const auto& [u, v] : triangle.sides())
    if (segments_meet(p, q, u, v)) return true;
  return false;
}

template <class N>
bool triangles_meet(const Triangle<N>& s, const Triangle<N>& t) {
  for (const auto& [u, v] : s.sides())
    if (segment_meets(u, v, t)) return true;
  for (const auto& [u, v] : t.sides())
    if (segment_meets(u, v, s)) return true;
  return false;
}

/// Where the inside of a triangle meets a plane that its corners are on both sides of: from where to where along a
/// direction in that plane.
template <class N>
std::optional<std::array<Fraction<N>, 2>> run_in_plane(const Triangle<N>& t, const std::array<N, 3>& heights,
                                                       const Vector<N>& along) {
  std::vector<Fraction<N>> ends;
  const std::array corners{t.a, t.b, t.c};
  for (size_t i = 0; i < 3; ++i) {
    const size_t j = (i + 1) % 3;
    if (sign(heights[i]) == 0) ends.push_back({dot(corners[i], along), N(1)});
    if (sign(heights[i]) * sign(heights[j]) >= 0) continue;
    const size_t low = sign(heights[i]) < 0 ? i : j, high = low == i ? j : i;
    ends.push_back({N(dot(corners[low], along) * heights[high] - dot(corners[high], along) * heights[low]),
                    N(heights[high] - heights[low])});
  }
  const auto [least, greatest] = std::minmax_element(heights.begin(), heights.end());
  if (sign(*least) >= 0 || sign(*greatest) <= 0) return std::nullopt;
  const auto [first, last] = std::minmax_element(ends.begin(), ends.end());
  return std::array{*first, *last};
}

/// True if the insides of two triangles in different planes have points in common.
template <class N>
bool go_through_each_other(const Triangle<N>& s, const Triangle<N>& t) {
  const Vector<N> of_s = s.normal(), of_t = t.normal(), along = cross(of_s, of_t);
  if (is_zero(along)) return false;
  const auto in_t = run_in_plane(s, {dot(of_t, s.a - t.a), dot(of_t, s.b - t.a), dot(of_t, s.c - t.a)}, along);
  const auto in_s = run_in_plane(t, {dot(of_s, t.a - s.a), dot(of_s, t.b - s.a), dot(of_s, t.c - s.a)}, along);
  return in_t && in_s && std::max((*in_t)[0], (*in_s)[0]) < std::min((*in_t)[1], (*in_s)[1]);
}

/// The point place / under, and its squared distance from the origin.
template <class N>
struct Nearest {
  Fraction<N> squared;
  Vector<N> place;
  N under;

  void keep_nearer(const Nearest& other) {
    if (other.squared < squared) *this = other;
  }
};

template <class N>
Nearest<N> nearest_of_segment(const Vector<N>& a, const Vector<N>& b) {
  Nearest<N> best{{dot(a, a), N(1)}, a, N(1)};
  best.keep_nearer({{dot(b, b), N(1)}, b, N(1)});
  const Vector<N> ab = b - a, across = cross(a, ab);
  const N whole = dot(ab, ab), along = -dot(a, ab);
  if (sign(along) > 0 && along < whole)
    best.keep_nearer({{dot(across, across), whole}, times(a, whole) + times(ab, along), whole});
  return best;
}

/// The triangle's nearest point to the origin: the nearest of its borders' points and of the foot on its face.
template <class N>
Nearest<N> nearest_of_triangle(const Triangle<N>& t) {
  Nearest<N> best = nearest_of_segment(t.a, t.b);
  best.keep_nearer(nearest_of_segment(t.b, t.c));
  best.keep_nearer(nearest_of_segment(t.c, t.a));
  const Vector<N> n = t.normal();
  if (is_zero(n)) return best;
  for (const auto& [u, v] : t.sides())
    if (sign(dot(n, cross(u, v))) < 0) return best;
  const N height = dot(t.a, n), whole = dot(n, n);
  best.keep_nearer({{N(height * height), whole}, times(n, height), whole});
  return best;
}

/// A convex body: its corners, and its faces as triangles.
template <class N>
struct Convex {
  std::vector<Vector<N>> corners, normals, edges;

  Convex(const std::vector<Vector<N>>& points, std::span<const std::array<uint32_t, 3>> triangles) {
    for (const auto& t : triangles) {
      const Triangle<N> triangle{points[t[0]], points[t[1]], points[t[2]]};
      corners.insert(corners.end(), {triangle.a, triangle.b, triangle.c});
      add(normals, triangle.normal());
      for (const auto& [u, v] : triangle.sides()) add(edges, v - u);
    }
  }
  std::array<N, 2> shadow(const Vector<N>& axis) const {
    std::array<N, 2> run{dot(corners[0], axis), dot(corners[0], axis)};
    for (const Vector<N>& p : corners) {
      const N at = dot(p, axis);
      run[0] = std::min(run[0], at), run[1] = std::max(run[1], at);
    }
    return run;
  }

 private:
  /// Directions that are there already are not added.
  static void add(std::vector<Vector<N>>& directions, const Vector<N>& one) {
    for (const Vector<N>& other : directions)
      if (is_zero(cross(one, other))) return;
    directions.push_back(one);
  }
};

/// By the theorem of separating axes: bodies with a volume have none in common if and only if a face's normal, or a
/// normal of two edges, parts them.
template <class N>
bool have_volume_in_common(const Convex<N>& a, const Convex<N>& b) {
  const auto parts = [&](const Vector<N>& axis) {
    if (is_zero(axis)) return false;
    const auto of_a = a.shadow(axis), of_b = b.shadow(axis);
    return of_a[1] <= of_b[0] || of_b[1] <= of_a[0];
  };
  if (std::ranges::any_of(a.normals, parts) || std::ranges::any_of(b.normals, parts)) return false;
  for (const Vector<N>& u : a.edges)
    for (const Vector<N>& v : b.edges)
      if (parts(cross(u, v))) return false;
  return true;
}

}  // namespace collided::test
