// Splits polygons by ear clipping in the plane of their Newell normal.
//
// The triangles that ear clipping cuts off bound together what the polygon bounds. So the number of triangles over any
// point of the plane is the polygon's winding number there, if all of them are positively oriented. Where the polygon
// does not cross itself that number is 0 or 1, and the triangles tile the polygon exactly, whichever ears come first.
// Hence only two things must be exact: the sign of an orientation, and the test for crossings.

#include "client/scenes/mesh_files/polygons.hpp"

#include <algorithm>
#include <cmath>

#include "client/scenes/vec3.hpp"

namespace collided::scenes {

namespace {

struct Point {
  double x = 0, y = 0;
  bool operator==(const Point&) const = default;
};

/// The sign of the sum of all terms, found without rounding: each partial sum is kept as non-overlapping parts.
int sign_of_sum(const std::array<double, 12>& terms) {
  std::vector<double> parts;
  for (double term : terms) {
    std::vector<double> next;
    for (const double part : parts) {
      const double sum = term + part, shifted = sum - term;
      const double error = (term - (sum - shifted)) + (part - shifted);
      if (error != 0) next.push_back(error);
      term = sum;
    }
    if (term != 0) next.push_back(term);
    parts = std::move(next);
  }
  return parts.empty() ? 0 : parts.back() > 0 ? 1 : -1;
}

int exact_orientation(Point a, Point b, Point c) {
  std::array<double, 12> terms{};
  size_t i = 0;
  const auto add = [&](double x, double y) {
    const double product = x * y;
    terms[i++] = product;
    terms[i++] = std::fma(x, y, -product);
  };
  add(a.x, b.y), add(-a.x, c.y), add(-c.x, b.y), add(-a.y, b.x), add(a.y, c.x), add(c.y, b.x);
  return sign_of_sum(terms);
}

/// 1 if the corner a, b, c turns left, -1 if it turns right, 0 if it is straight.
int orientation(Point a, Point b, Point c) {
  constexpr double kErrorBound = 3.3306690738754716e-16;  // Shewchuk's bound for this expression
  const double left = (a.x - c.x) * (b.y - c.y), right = (a.y - c.y) * (b.x - c.x);
  const double difference = left - right, bound = kErrorBound * (std::abs(left) + std::abs(right));
  if (difference > bound) return 1;
  if (-difference > bound) return -1;
  return exact_orientation(a, b, c);
}

/// Scales by a power of two so that the largest coordinate is in [0.5, 1), or 0.
void scale_to_one(std::vector<Vec3d>& corners) {
  double max = 0;
  for (const Vec3d& p : corners)
    for (const double x : p) max = std::max(max, std::abs(x));
  int exponent = 0;
  std::frexp(max, &exponent);
  for (Vec3d& p : corners)
    for (double& x : p) x = std::ldexp(x, -exponent);
}

/// Below this extent, or area, of a polygon of size 1 there is no plane to split it in.
constexpr double kFlat = 1e-12;

/// Relative to the first corner, and of size 1.
std::vector<Vec3d> normalised(std::vector<Vec3d> corners) {
  scale_to_one(corners);  // so that no difference overflows
  const Vec3d first = corners[0];
  for (Vec3d& p : corners)
    for (size_t k = 0; k < 3; ++k) p[k] -= first[k];
  scale_to_one(corners);
  return corners;
}

bool is_straight(const std::vector<Vec3d>& corners) {
  Vec3d farthest = corners[0];
  for (const Vec3d& p : corners)
    if (dot(p, p) > dot(farthest, farthest)) farthest = p;
  return std::all_of(corners.begin(), corners.end(), [&](const Vec3d& p) {
    const Vec3d area = cross(p, farthest);
    return dot(area, area) <= kFlat * kFlat;
  });
}

Vec3d newell_normal(const std::vector<Vec3d>& corners) {
  Vec3d sum{};
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3d area = cross(corners[i], corners[(i + 1) % corners.size()]);
    for (size_t k = 0; k < 3; ++k) sum[k] += area[k];
  }
  return sum;
}

/// Coordinates in the plane. Those that rounding alone makes differ from 0 become 0, so that no product underflows.
std::vector<Point> project(const std::vector<Vec3d>& corners, Vec3d normal) {
  normal = unit(normal);
  size_t axis = 0;
  for (size_t k = 1; k < 3; ++k)
    if (std::abs(normal[k]) < std::abs(normal[axis])) axis = k;
  Vec3d u{};
  for (size_t k = 0; k < 3; ++k) u[k] = (k == axis ? 1.0 : 0.0) - normal[k] * normal[axis];
  u = unit(u);
  const Vec3d w = cross(normal, u);
  const auto clean = [](double x) { return std::abs(x) < 0x1p-200 ? 0.0 : x; };
  std::vector<Point> points;
  for (const Vec3d& p : corners) points.push_back({clean(dot(p, u)), clean(dot(p, w))});
  return points;
}

bool is_convex(const std::vector<Point>& p) {
  const size_t n = p.size();
  for (size_t i = 0; i < n; ++i) {
    if (orientation(p[i], p[(i + 1) % n], p[(i + 2) % n]) <= 0) return false;
    if (i > 0 && i + 1 < n && orientation(p[0], p[i], p[i + 1]) <= 0) return false;
    if (i > 1 && orientation(p[0], p[1], p[i]) <= 0) return false;  // else it goes round more than once
  }
  return true;
}

struct Box {
  Point lower, upper;
  Box(Point a, Point b)
      : lower{std::min(a.x, b.x), std::min(a.y, b.y)}, upper{std::max(a.x, b.x), std::max(a.y, b.y)} {}
  bool meets(const Box& o) const {
    return lower.x <= o.upper.x && o.lower.x <= upper.x && lower.y <= o.upper.y && o.lower.y <= upper.y;
  }
  /// Their common part has a length.
  bool overlaps(const Box& o) const {
    return std::max(lower.x, o.lower.x) < std::min(upper.x, o.upper.x) ||
           std::max(lower.y, o.lower.y) < std::min(upper.y, o.upper.y);
  }
  bool has(Point p) const { return lower.x <= p.x && p.x <= upper.x && lower.y <= p.y && p.y <= upper.y; }
};

class Crossings {
 public:
  explicit Crossings(const std::vector<Point>& points) : p_(points), n_(points.size()) {}

  /// True if two sides cross, at a corner or between corners, or run along each other in one direction. Sides may
  /// touch, and run along each other in opposite directions, as bridges to holes do.
  bool any() const {
    for (size_t i = 0; i < n_; ++i)
      for (size_t j = i + 1; j < n_; ++j)
        if (box(i).meets(box(j)) && do_cross(i, j)) return true;
    return false;
  }

 private:
  Box box(size_t i) const { return {p_[i], p_[next(i)]}; }
  size_t next(size_t i) const { return (i + 1) % n_; }
  bool do_cross(size_t i, size_t j) const {
    const Point a = p_[i], b = p_[next(i)], c = p_[j], d = p_[next(j)];
    const int ac = orientation(a, b, c), ad = orientation(a, b, d);
    const int ca = orientation(c, d, a), cb = orientation(c, d, b);
    if (ac * ad < 0 && ca * cb < 0) return true;
    if (ac == 0 && ad == 0) return (b.x - a.x) * (d.x - c.x) + (b.y - a.y) * (d.y - c.y) > 0 && box(i).overlaps(box(j));
    return goes_through(j, i, ac) || goes_through(i, j, ca);
  }
  /// True if the path goes from one side of side `s` to the other at corner `c`. `side`: on which side of s the corner
  /// is.
  bool goes_through(size_t c, size_t s, int side) const {
    const Point a = p_[s], b = p_[next(s)], at = p_[c];
    if (side != 0 || at == a || at == b || !Box(a, b).has(at)) return false;
    return orientation(a, b, p_[(c + n_ - 1) % n_]) * orientation(a, b, p_[next(c)]) < 0;
  }

  const std::vector<Point>& p_;
  const size_t n_;
};

class EarClipping {
 public:
  explicit EarClipping(const std::vector<Point>& points) : p_(points), is_ear_(points.size()) {
    const auto n = static_cast<uint32_t>(points.size());
    for (uint32_t i = 0; i < n; ++i) previous_.push_back((i + n - 1) % n), next_.push_back((i + 1) % n);
    left_ = n;
  }

  std::optional<std::vector<std::array<uint32_t, 3>>> run() {
    find_ears();
    while (left_ > 3) {
      const auto ear = choose();
      if (!ear) return {};
      clip(*ear);
    }
    if (turn(at_) < 0) return {};
    triangles_.push_back({previous_[at_], at_, next_[at_]});
    return std::move(triangles_);
  }

 private:
  int turn(uint32_t i) const { return orientation(p_[previous_[i]], p_[i], p_[next_[i]]); }

  /// True if the triangle at the corner can be cut off: it turns left, and holds no other corner. `on_sides`: corners
  /// on its sides count as well.
  bool is_ear(uint32_t i, bool on_sides) const {
    if (turn(i) <= 0) return false;
    const Point a = p_[previous_[i]], b = p_[i], c = p_[next_[i]];
    const int least = on_sides ? 0 : 1;
    const Box ab(a, b), box({std::min(ab.lower.x, c.x), std::min(ab.lower.y, c.y)},
                            {std::max(ab.upper.x, c.x), std::max(ab.upper.y, c.y)});
    for (uint32_t j = next_[next_[i]]; j != previous_[i]; j = next_[j]) {
      const Point q = p_[j];
      if (!box.has(q) || q == a || q == b || q == c) continue;
      if (orientation(a, b, q) >= least && orientation(b, c, q) >= least && orientation(c, a, q) >= least) return false;
    }
    return true;
  }

  void find_ears() {
    uint32_t i = at_;
    do is_ear_[i] = is_ear(i, true);
    while ((i = next_[i]) != at_);
  }

  template <class Test>
  std::optional<uint32_t> first(const Test& test) const {
    uint32_t i = at_;
    do
      if (test(i)) return i;
    while ((i = next_[i]) != at_);
    return {};
  }

  /// The next ear; where corners touch sides, or are straight, what still keeps the area.
  std::optional<uint32_t> choose() {
    const auto flagged = [&](uint32_t i) { return is_ear_[i] != 0; };
    if (const auto ear = first(flagged)) return ear;
    find_ears();
    if (const auto ear = first(flagged)) return ear;
    if (const auto ear = first([&](uint32_t i) { return is_ear(i, false); })) return ear;
    return first([&](uint32_t i) { return turn(i) == 0; });
  }

  void clip(uint32_t i) {
    const uint32_t before = previous_[i], after = next_[i];
    triangles_.push_back({before, i, after});
    next_[before] = after;
    previous_[after] = before;
    --left_;
    is_ear_[before] = is_ear(before, true);
    is_ear_[after] = is_ear(after, true);
    at_ = after;
  }

  const std::vector<Point>& p_;
  std::vector<char> is_ear_;
  std::vector<uint32_t> previous_, next_;
  std::vector<std::array<uint32_t, 3>> triangles_;
  uint32_t at_ = 0, left_ = 0;
};

std::vector<std::array<uint32_t, 3>> fan(size_t corners) {
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 2; i < corners; ++i) triangles.push_back({0, i - 1, i});
  return triangles;
}

}  // namespace

std::optional<std::vector<std::array<uint32_t, 3>>> split_polygon(const std::vector<Vec3d>& given) {
  const std::vector<Vec3d> corners = normalised(given);
  const Vec3d normal = newell_normal(corners);
  if (dot(normal, normal) <= kFlat * kFlat) {
    if (is_straight(corners)) return fan(corners.size());  // no area to keep
    return {};
  }
  const std::vector<Point> points = project(corners, normal);
  if (is_convex(points)) return fan(points.size());
  if (points.size() > kMaxConcaveCorners || Crossings(points).any()) return {};
  return EarClipping(points).run();
}

}  // namespace collided::scenes
