#include "gpu/exact/features.hpp"

#include <initializer_list>
#include <type_traits>
#include <utility>
#include <vector>

#include "gpu/exact/fixed/differences.hpp"
#include "gpu/exact/fixed/polynomial.hpp"

namespace collided::exact {
namespace {

// The functions below take forms, or polynomials of fixed size, which have the same operators.
using fixed::wide_cross;
using fixed::wide_dot;

/// Vectors p and q from the ends of a segment to a point, or both from the point to the ends, and n = p x q or -p x q.
template <class Linear>
struct Side {
  const Vec3<Linear>&p, &q;
  const Vec3<decltype(p.x * q.x)>& n;
};

Form form_of(Form f) { return f; }
template <int degree, int N>
Form form_of(const fixed::Polynomial<degree, N>& f) {
  Form form;
  form.c.clear();
  for (const fixed::Integer<N>& x : f.c) {
    const bool is_negative = x.is_negative();
    const fixed::Integer<N> size = is_negative ? fixed::Integer<N>::of(0) - x : x;
    form.c.push_back(Number::of(size.limb, N, is_negative));
  }
  return form;
}

/// A case whose forms are made one after the other, until one of them shows that it never holds in [0, 1].
class Draft {
 public:
  template <class Make>
  Draft& zero(const Make& make) {
    return take(make, case_.zero, [](const auto& f) { return closed_sign(f) == 0; });
  }
  template <class Make>
  Draft& not_negative(const Make& make) {
    return take(make, case_.not_negative, [](const auto& f) { return closed_sign(f) >= 0; });
  }
  template <class Make>
  Draft& not_zero(const Make& make) {
    return take(make, case_.not_zero, [](const auto& f) { return !f.vanishes(); });
  }
  /// The form is >= 0 wherever the others hold.
  template <class Make>
  Draft& implied(const Make& make) {
    return take(make, case_.implied, [](const auto& f) { return closed_sign(f) >= 0; });
  }
  bool may_hold() const { return may_hold_; }
  void add_to(Contact& contact) {
    if (may_hold_) contact.cases.push_back(std::move(case_));
  }

 private:
  template <class Make, class MayHold>
  Draft& take(const Make& make, std::vector<Form>& forms, const MayHold& may_hold) {
    if (!may_hold_) return *this;
    auto f = make();
    may_hold_ = may_hold(f);
    if (may_hold_) forms.push_back(reduced(form_of(std::move(f))));
    return *this;
  }

  Case case_;
  bool may_hold_ = true;
};

/// distance <= h as a form that is not negative, given distance * |d| (its square) and d.
template <class Squared, class Linear, class Component>
Squared within(const Squared& squared, const Linear& thickness, const Vec3<Component>& d) {
  return thickness * thickness * wide_dot(d, d) - squared;
}

// Each component of d alone has to be within the limit. Where the largest one crosses 0, double precision loses the
// sign of the whole sum, but still sees that another component is too large. Only exponents that lie far apart need it.
template <class Limit, class Component>
void imply_components_within(Draft& draft, const Limit& limit, const Vec3<Component>& d) {
  if constexpr (std::is_same_v<Component, Form>)
    for (const Form* x : {&d.x, &d.y, &d.z}) draft.implied([&] { return limit - *x * *x; });
}

template <class Linear>
void add_point_near_point(Contact& contact, const Vec3<Linear>& d, const Linear& thickness) {
  Draft draft;
  imply_components_within(draft, thickness * thickness, d);
  draft.not_negative([&] { return thickness * thickness - wide_dot(d, d); }).add_to(contact);
}

// p and q are parallel and do not lead to the same side. True of segments without length, too.
template <class Linear>
void add_point_on_segment(Contact& contact, const Side<Linear>& side) {
  Draft()
      .zero([&] { return side.n.x; })
      .zero([&] { return side.n.y; })
      .zero([&] { return side.n.z; })
      .not_negative([&] { return -wide_dot(side.p, side.q); })
      .add_to(contact);
}

// The point's foot is on the segment e = p - q, which has a length; |n| = distance * |e|.
template <class Linear>
void add_point_near_segment(Contact& contact, const Side<Linear>& side, const Linear& thickness) {
  const Vec3<Linear> e = side.p - side.q;
  Draft draft;
  draft.not_negative([&] { return wide_dot(side.p, e); })
      .not_negative([&] { return -wide_dot(side.q, e); })
      .not_zero([&] { return wide_dot(e, e); });
  if (draft.may_hold()) imply_components_within(draft, thickness * thickness * wide_dot(e, e), side.n);
  draft.not_negative([&] { return within(wide_dot(side.n, side.n), thickness, e); }).add_to(contact);
}

// The weights of the closest points, times n^2, are not negative, and |volume| = distance * |n|. Without thickness
// the volume has to be 0, which is necessary in any case.
template <class Linear, class Normal, class Volume>
void add_planes_near(Contact& contact, std::initializer_list<const Normal*> sides, const Volume& volume,
                     const Normal& n, const Linear& thickness) {
  Draft draft;
  for (const Normal* side : sides) draft.not_negative([&] { return wide_dot(*side, n); });
  draft.not_zero([&] { return wide_dot(n, n); });
  if (!thickness.vanishes()) draft.not_negative([&] { return within(volume * volume, thickness, n); });
  draft.add_to(contact);
}

// The points at the sides and, with a thickness, at their ends. Without one, a point at an end is on the side, too.
template <class Linear>
void add_outline(Contact& contact, std::initializer_list<Side<Linear>> sides,
                 std::initializer_list<const Vec3<Linear>*> to_ends, const Linear& thickness) {
  if (thickness.vanishes()) {
    for (const Side<Linear>& side : sides) add_point_on_segment(contact, side);
    return;
  }
  for (const Side<Linear>& side : sides) add_point_near_segment(contact, side, thickness);
  for (const Vec3<Linear>* d : to_ends) add_point_near_point(contact, *d, thickness);
}

// Adds that no axis keeps the features apart. These forms are lines, so they cost little, and where exponents lie far
// apart one coordinate mostly decides. `to_ends`: the differences between the corners of both features.
template <class Linear>
void add_axes(Contact& contact, std::initializer_list<const Vec3<Linear>*> to_ends, const Linear& thickness) {
  if constexpr (std::is_same_v<Linear, Form>)
    for (Form Vec3<Form>::*axis : {&Vec3<Form>::x, &Vec3<Form>::y, &Vec3<Form>::z})
      for (const bool is_above : {false, true}) {
        std::vector<Form>& forms = contact.alternatives.emplace_back();
        for (const Vec3<Form>* d : to_ends) forms.push_back(is_above ? thickness - d->*axis : thickness + d->*axis);
      }
}

// With A, B, C from the corners to the vertex, n = (b - a) x (c - a) = B x C + C x A + A x B. The weights of the vertex
// in the triangle are (B x C) n, (C x A) n and (A x B) n over n^2, and A (B x C) is its height times |n|. Where no
// weight is negative, the distance is the height, else that to a side; a triangle without area is its sides.
template <class Linear>
Contact vertex_triangle_contact(const QueryOf<Linear>& query) {
  const auto& [v, a, b, c] = query.points;
  const Linear& thickness = query.thickness;
  const Vec3<Linear> A = v - a, B = v - b, C = v - c;
  Contact contact;
  add_axes<Linear>(contact, {&A, &B, &C}, thickness);
  if (alternatives_exclude(contact)) return contact;
  const auto bc = wide_cross(B, C);
  const auto volume = wide_dot(A, bc);
  if (thickness.vanishes()) contact.necessary = form_of(volume);
  if (closed_sign(contact.necessary) != 0) return contact;
  const auto ca = wide_cross(C, A), ab = wide_cross(A, B), n = bc + ca + ab;
  add_planes_near(contact, {&bc, &ca, &ab}, volume, n, thickness);
  add_outline<Linear>(contact, {{B, C, bc}, {C, A, ca}, {A, B, ab}}, {&A, &B, &C}, thickness);
  return contact;
}

// With A = a0 - b0, B = a0 - b1, C = a1 - b0, D = a1 - b1, n = (a1 - a0) x (b1 - b0) = (C - A) x (A - B). The closest
// points of the two lines have the weights (A x B) n of a1, (D x C) n of a0, (C x A) n of b1 and (B x D) n of b0, over
// n^2, and A (B x C) is the lines' distance times |n|. Where a weight is negative or the edges are parallel, an end
// of one edge is among the closest points.
template <class Linear>
Contact edge_edge_contact(const QueryOf<Linear>& query) {
  const auto& [a0, a1, b0, b1] = query.points;
  const Linear& thickness = query.thickness;
  const Vec3<Linear> A = a0 - b0, B = a0 - b1, C = a1 - b0, D = a1 - b1;
  Contact contact;
  add_axes<Linear>(contact, {&A, &B, &C, &D}, thickness);
  if (alternatives_exclude(contact)) return contact;
  const auto ab = wide_cross(A, B);
  const auto volume = wide_dot(C, ab);
  if (thickness.vanishes()) contact.necessary = form_of(volume);
  if (closed_sign(contact.necessary) != 0) return contact;
  const auto dc = wide_cross(D, C), ca = wide_cross(C, A), bd = wide_cross(B, D), n = wide_cross(C - A, A - B);
  add_planes_near(contact, {&ab, &dc, &ca, &bd}, volume, n, thickness);
  add_outline<Linear>(contact, {{A, B, ab}, {D, C, dc}, {C, A, ca}, {B, D, bd}}, {&A, &B, &C, &D}, thickness);
  return contact;
}

template <class Linear>
Contact contact_of_any(ContactKind kind, const QueryOf<Linear>& query) {
  return kind == ContactKind::kVertexTriangle ? vertex_triangle_contact(query) : edge_edge_contact(query);
}

/// Makes the contact in numbers of W limbs, which the unit has to fit.
template <int W>
Contact fixed_contact(ContactKind kind, const fixed::Unit& unit, const Vec3<double> (&start)[4],
                      const Vec3<double> (&end)[4], double thickness) {
  using Linear = fixed::Polynomial<1, W>;
  const auto linear = [&](double from, double to) { return Linear{{unit.count<W>(from), unit.count<W>(to)}}; };
  QueryOf<Linear> query{{}, linear(thickness, thickness)};
  for (size_t i = 0; i < 4; ++i) {
    const Vec3<double>&p = start[i], &q = end[i];
    query.points[i] = {linear(p.x, q.x), linear(p.y, q.y), linear(p.z, q.z)};
  }
  return contact_of_any(kind, query);
}

}  // namespace

Contact contact_of(ContactKind kind, const ExactQuery& query) { return contact_of_any(kind, query); }

Contact contact_in_motion(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                          double thickness) {
  fixed::Unit unit;
  unit.see(start);
  unit.see(end);
  unit.see(thickness);
  if (unit.fits<1>()) return fixed_contact<1>(kind, unit, start, end, thickness);
  if (unit.fits<2>()) return fixed_contact<2>(kind, unit, start, end, thickness);
  return contact_of(kind, in_motion(start, end, thickness));
}

}  // namespace collided::exact
