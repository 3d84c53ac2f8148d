#pragma once
// The surfaces around the closest points of two features: what they are named by, and whether a surface comes nearer to
// the other point beside its own.

#include "gpu/base/fans.hpp"
#include "gpu/base/precision.hpp"
#include "gpu/contacts/kinds.hpp"
#include "gpu/narrow/distance.hpp"

namespace collided {

/// A corner, a side or a face, by its vertices, ascending.
struct NamedFeature {
  uint32_t count;  ///< of vertices: 1 to 3
  uint32_t v[3];

  COLLIDED_HD static NamedFeature corner(uint32_t v) { return {1, {v, 0, 0}}; }
  COLLIDED_HD static NamedFeature side(uint32_t a, uint32_t b) { return {2, {min(a, b), max(a, b), 0}}; }
  COLLIDED_HD static NamedFeature face(uint32_t a, uint32_t b, uint32_t c) {
    const uint32_t least = min(a, min(b, c)), most = max(a, max(b, c));
    return {3, {least, a ^ b ^ c ^ least ^ most, most}};
  }
  /// Whether it comes before another one in an order that depends on nothing but the two.
  COLLIDED_HD bool is_before(const NamedFeature& other) const {
    if (count != other.count) return count < other.count;
    for (int k = 0; k < 3; ++k)
      if (v[k] != other.v[k]) return v[k] < other.v[k];
    return false;
  }
};

/// Of a contact's two features, those that its closest points are on. `bits`: as in FeatureBits.
struct NamedPair {
  NamedFeature first, second;
};
COLLIDED_HD inline NamedPair named_features(const VertexTriangle&, const Stencil& s, uint8_t bits) {
  const int at = bits & kOfTriangle;
  const NamedFeature vertex = NamedFeature::corner(s.v[0]);
  if (at == 0) return {vertex, NamedFeature::face(s.v[1], s.v[2], s.v[3])};
  if (at > 3) return {vertex, NamedFeature::corner(at == 4 ? s.v[1] : at == 5 ? s.v[2] : s.v[3])};
  return {vertex, NamedFeature::side(at == 1 ? s.v[3] : s.v[1], at == 2 ? s.v[3] : s.v[2])};
}
COLLIDED_HD inline NamedFeature named_on_edge(uint32_t from, uint32_t to, int end) {
  return end == 0 ? NamedFeature::side(from, to) : NamedFeature::corner(end == 1 ? from : to);
}
COLLIDED_HD inline NamedPair named_features(const EdgeEdge&, const Stencil& s, uint8_t bits) {
  return {named_on_edge(s.v[0], s.v[1], bits & kOfFirstEdge),
          named_on_edge(s.v[2], s.v[3], (bits & kOfSecondEdge) / 4)};
}

/// The direction from the closest point of one feature to that of another.
struct Toward {
  Vec3<double> unit;
  double error;  ///< of each component, at most; 1: nothing is known
};

/// Brings a vector near 1, so that nothing under- or overflows; 0 stays 0.
COLLIDED_HD inline Vec3<double> brought_near_1(const Vec3<double>& v) {
  const double size = largest_component(v);
  return size > 0 ? unit_scale(size) * v : v;
}

/// Of an element's corners, one that is not v; a loose edge has one.
COLLIDED_HD inline uint32_t other_corner(const Vec3<uint32_t>& t, uint32_t v) { return t.x == v ? t.y : t.x; }
/// The one besides v and w. The corners of a loose edge are a, b, b.
COLLIDED_HD inline uint32_t third_corner(const Vec3<uint32_t>& t, uint32_t v, uint32_t w) {
  return t.y == t.z ? w : t.x ^ t.y ^ t.z ^ v ^ w;
}

struct FourPoints {
  Vec3<double> p[4];
};

/// The surfaces of a scene in one frame.
template <class Real>
struct Surfaces {
  static constexpr double kClearSlope = 1.0 / 64;
  static constexpr double kRounding = 0x1p-40;  ///< of a slope whose direction is not nearly without a length

  const Vec3<Real>* positions;
  Fans fans;

  COLLIDED_HD Vec3<double> at(uint32_t v) const { return convert<double>(positions[v]); }
  COLLIDED_HD FourPoints points_of(const Stencil& s) const {
    return {{at(s.v[0]), at(s.v[1]), at(s.v[2]), at(s.v[3])}};
  }
  COLLIDED_HD Vec3<double> along(uint32_t from, uint32_t to) const { return brought_near_1(at(to) - at(from)); }

  /// How many elements are looked at for those with this corner or side.
  COLLIDED_HD uint32_t count_elements(const NamedFeature& at) const {
    return at.count == 1 ? fans.size(at.v[0]) : min(fans.size(at.v[0]), fans.size(at.v[1]));
  }
  /// use(corners) for each element with this corner or side, in order, until it returns false.
  template <class Use>
  COLLIDED_HD void for_each_element(const NamedFeature& at, const Use& use) const {
    if (at.count == 1) return fans.for_each(at.v[0], use);
    const bool is_second = fans.size(at.v[1]) < fans.size(at.v[0]);
    const uint32_t other = at.v[is_second ? 0 : 1];
    fans.for_each(at.v[is_second ? 1 : 0],
                  [&](const Vec3<uint32_t>& t) { return (t.x != other && t.y != other && t.z != other) || use(t); });
  }

  /// Whether the surface comes clearly nearer beside the point of the first or the second feature: kNearerAtFirst,
  /// kNearerAtSecond. All contacts with the same two features have the same answer, whatever their elements are.
  COLLIDED_HD uint8_t nearer_beside(const NamedPair& pair) const {
    const bool swapped = pair.second.is_before(pair.first);
    const NamedFeature& a = swapped ? pair.second : pair.first;
    const NamedFeature& b = swapped ? pair.first : pair.second;
    const Toward toward = direction_between(a, b);
    const bool at_a = comes_nearer(a, toward), at_b = comes_nearer(b, {-1.0 * toward.unit, toward.error});
    return static_cast<uint8_t>((swapped ? at_b : at_a) * kNearerAtFirst | (swapped ? at_a : at_b) * kNearerAtSecond);
  }

 private:
  /// From a's point to b's, where a is before b: a corner and anything, or two sides.
  COLLIDED_HD Toward direction_between(const NamedFeature& a, const NamedFeature& b) const {
    constexpr double kError = 0x1p-44;  // of vectors near 1
    const Vec3<double> origin = at(a.v[0]);
    Vec3<double> q = at(b.v[0]) - origin, e = {0, 0, 0}, f = {0, 0, 0};
    if (b.count > 1) e = at(b.v[1]) - at(b.v[0]);
    if (b.count > 2) f = at(b.v[2]) - at(b.v[0]);
    if (a.count > 1) f = at(a.v[1]) - origin;
    const double extent = max(largest_component(q), max(largest_component(e), largest_component(f)));
    if (!(extent > 0)) return nothing_known();
    const double scale = unit_scale(extent);
    q = scale * q, e = scale * e, f = scale * f;
    if (b.count == 1) return directed(q, kError);
    if (b.count == 2 && a.count == 1) {
      const double length2 = dot(e, e);
      return length2 > 0 ? directed(q - (dot(q, e) / length2) * e, kError) : nothing_known();
    }
    const Vec3<double> n = cross(e, f);
    const double n2 = dot(n, n);
    if (!(n2 > 0)) return nothing_known();
    return directed((dot(n, q) / n2) * n, kError * std::sqrt(dot(e, e) * dot(f, f) / n2));
  }
  COLLIDED_HD static Toward nothing_known() { return {{0, 0, 0}, 1}; }
  COLLIDED_HD static Toward directed(const Vec3<double>& gap, double error) {
    const double size = largest_component(gap);
    if (!(size > 0)) return nothing_known();
    const double scale = unit_scale(size);
    const Vec3<double> near_1 = scale * gap;
    return {(1 / std::sqrt(dot(near_1, near_1))) * near_1, min(scale * error, 1.0)};
  }

  COLLIDED_HD bool comes_nearer(const NamedFeature& at, const Toward& toward) const {
    const double least = kClearSlope + 2 * toward.error + kRounding;
    if (!(least < 1) || at.count == 3) return false;
    return at.count == 1 ? comes_nearer_around(at, toward.unit, least) : comes_nearer_across(at, toward.unit, least);
  }
  /// Whether a point that goes this way comes nearer by more than `least` of its way.
  COLLIDED_HD static bool is_steep(const Vec3<double>& direction, const Vec3<double>& toward, double least) {
    const double nearer = dot(direction, toward);
    return nearer > 0 && nearer * nearer > least * least * dot(direction, direction);
  }
  /// Around a corner: along each side, and within each triangle between its sides.
  COLLIDED_HD bool comes_nearer_around(const NamedFeature& at, const Vec3<double>& toward, double least) const {
    bool found = false;
    for_each_element(at, [&](const Vec3<uint32_t>& t) {
      const uint32_t v = at.v[0], w = other_corner(t, v);
      const Vec3<double> b = along(v, w), c = along(v, third_corner(t, v, w));
      found = is_steep(b, toward, least) || is_steep(c, toward, least) || is_steep_between(b, c, toward, least);
      return !found;
    });
    return found;
  }
  COLLIDED_HD static bool is_steep_between(const Vec3<double>& b, const Vec3<double>& c, const Vec3<double>& toward,
                                           double least) {
    const Vec3<double> n = cross(b, c);
    const double n2 = dot(n, n);
    if (!(n2 > 0x1p-60)) return false;  // nearly no area
    if (!(dot(cross(b, toward), n) >= 0 && dot(cross(toward, c), n) >= 0)) return false;
    const Vec3<double> off = cross(n, toward);
    return dot(off, off) > least * least * n2;
  }
  /// From a side into the triangles that have it.
  COLLIDED_HD bool comes_nearer_across(const NamedFeature& at, const Vec3<double>& toward, double least) const {
    const Vec3<double> e = along(at.v[0], at.v[1]);
    const double e2 = dot(e, e);
    bool found = false;
    if (!(e2 > 0)) return false;
    for_each_element(at, [&](const Vec3<uint32_t>& t) {
      if (t.y == t.z) return true;
      const Vec3<double> f = along(at.v[0], third_corner(t, at.v[0], at.v[1])), across = f - (dot(f, e) / e2) * e;
      found = dot(across, across) > 0x1p-60 && is_steep(across, toward, least);
      return !found;
    });
    return found;
  }
};

}  // namespace collided
