#include "gpu/exact/features.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "gpu/exact/fixed/polynomial.hpp"
#include "gpu/exact/parts.hpp"

namespace collided::exact {
namespace {

// The conditions below are functions of parts, which are exact or rough (parts.hpp).
using fixed::wide_dot;

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

template <int degree, int N>
LazyForm lazy(const fixed::Polynomial<degree, N>& f) {
  return LazyForm(reduced(form_of(f)));
}
LazyForm lazy(LazyForm f) { return f; }
int closed_sign(const LazyForm& f) { return f.closed_sign(); }
using fixed::closed_sign;

/// Features whose numbers fit integers of W limbs.
template <ContactKind kind, int W>
class OfFixedSize {
 public:
  static constexpr ContactKind kKind = kind;
  static constexpr bool kIsFixed = true;
  using Linear = fixed::Polynomial<1, W>;

  explicit OfFixedSize(const QueryOf<Linear>& query) : parts_(query) {}

  bool has_limit() const { return !parts_.limit().vanishes(); }
  template <class Make>
  auto form(const Make& make) const {
    return make(parts_);
  }
  std::shared_ptr<const Numbers> numbers() const { return nullptr; }

 private:
  ExactParts<kind, Linear> parts_;
};

/// Points whose exponents may lie far apart.
struct Points {
  Vec3<double> start[4], end[4];
  ContactDistance limit;

  Points(const Vec3<double> (&from)[4], const Vec3<double> (&to)[4], const ContactDistance& within) : limit(within) {
    std::copy_n(from, 4, start);
    std::copy_n(to, 4, end);
  }
};

/// Features in rough numbers and, of the whole way, exact ones. Degree 0: at rest.
template <ContactKind kind, int degree>
class AnyNumbers : public Numbers {
 public:
  explicit AnyNumbers(const Points& points)
      : motion_(points.start, points.end, points.limit), points_(points), parts_(motion_) {}
  explicit AnyNumbers(const RoughMotion& part) : motion_(part), parts_(motion_) {}

  const RoughParts<kind, degree>& rough() const { return parts_; }
  bool has_limit() const { return motion_.end(1).limit.size != 0; }
  bool has_exact() const { return points_.has_value(); }
  const ExactParts<kind, Form>& exact() const {
    return exact_.get([&] {
      const auto& [start, end, limit] = *points_;
      return ExactParts<kind, Form>(degree == 0 ? at_rest(end, limit) : in_motion(start, end, limit));
    });
  }
  double ratio_at(const RoughForm::Place& place) const override { return motion_.ratio_at(place); }
  std::vector<Contact> cut(const RoughForm::Place& from, const RoughForm::Place& to) const override;

 private:
  const RoughMotion motion_;
  const std::optional<Points> points_;
  const RoughParts<kind, degree> parts_;
  Memo<ExactParts<kind, Form>> exact_;
};

template <ContactKind kind, int degree>
class OfAnySize {
 public:
  static constexpr ContactKind kKind = kind;
  static constexpr bool kIsFixed = false;

  template <class Motion>
  explicit OfAnySize(const Motion& motion) : numbers_(std::make_shared<AnyNumbers<kind, degree>>(motion)) {}

  bool has_limit() const { return numbers_->has_limit(); }
  template <class Make>
  LazyForm form(const Make& make) const {
    if (!numbers_->has_exact()) return LazyForm(make(numbers_->rough()), nullptr);
    return LazyForm(make(numbers_->rough()),
                    [make, numbers = numbers_.get()] { return reduced(make(numbers->exact())); });
  }
  std::shared_ptr<const Numbers> numbers() const { return numbers_; }

 private:
  std::shared_ptr<const AnyNumbers<kind, degree>> numbers_;
};

/// A case whose forms are made one after the other, until one of them shows that it never holds in [0, 1].
template <class Features>
class Draft {
 public:
  explicit Draft(const Features& features) : features_(features) {}

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
  /// Adds that `sum`, of the squares of what `for_components` passes on, is within the limit.
  template <class Sum, class Limit, class Components>
  Draft& within(const Limit& limit, const Sum& sum, const Components& for_components) {
    not_negative([=](const auto& f) { return limit(f) - sum(f); });
    if constexpr (!Features::kIsFixed)
      if (may_hold_) {
        case_.limit = features_.form(limit);
        for_components([&](const auto& component) { case_.components.push_back(features_.form(component)); });
      }
    return *this;
  }
  void add_to(Contact& contact) {
    if (may_hold_) contact.cases.push_back(std::move(case_));
  }

 private:
  template <class Make, class MayHold>
  Draft& take(const Make& make, std::vector<LazyForm>& forms, const MayHold& may_hold) {
    if (!may_hold_) return *this;
    auto f = features_.form(make);
    may_hold_ = may_hold(f);
    if (may_hold_) forms.push_back(lazy(std::move(f)));
    return *this;
  }

  const Features& features_;
  Case case_;
  bool may_hold_ = true;
};

constexpr auto kAxes = [](const auto& use) {
  use([](const auto& v) { return v.x; });
  use([](const auto& v) { return v.y; });
  use([](const auto& v) { return v.z; });
};

template <class Parts>
auto limit_of(const Parts& f) {
  return f.limit() * f.limit();
}

template <class Features>
void add_point_near_point(Contact& contact, const Features& features, int i) {
  Draft(features)
      .within([](const auto& f) { return limit_of(f); }, [=](const auto& f) { return wide_dot(f.d(i), f.d(i)); },
              [=](const auto& use) { kAxes([&](auto axis) { use([=](const auto& f) { return axis(f.d(i)); }); }); })
      .add_to(contact);
}

// P and Q are parallel and do not lead to the same side. True of segments without length, too.
template <class Features>
void add_point_on_segment(Contact& contact, const Features& features, int i) {
  Draft draft(features);
  kAxes([&](auto axis) { draft.zero([=](const auto& f) { return axis(f.side(i)); }); });
  const fixed::Side side = fixed::Sides<Features::kKind>::at(i);
  draft.not_negative([=](const auto& f) { return -wide_dot(f.d(side.p), f.d(side.q)); }).add_to(contact);
}

// The point's foot is on the segment e = P - Q, which has a length; |P x Q| = distance * |e|.
template <class Features>
void add_point_near_segment(Contact& contact, const Features& features, int i) {
  const fixed::Side side = fixed::Sides<Features::kKind>::at(i);
  Draft(features)
      .not_negative([=](const auto& f) { return wide_dot(f.d(side.p), f.edge(i)); })
      .not_negative([=](const auto& f) { return -wide_dot(f.d(side.q), f.edge(i)); })
      .not_zero([=](const auto& f) { return wide_dot(f.edge(i), f.edge(i)); })
      .within([=](const auto& f) { return limit_of(f) * wide_dot(f.edge(i), f.edge(i)); },
              [=](const auto& f) { return wide_dot(f.side(i), f.side(i)); },
              [=](const auto& use) { kAxes([&](auto axis) { use([=](const auto& f) { return axis(f.side(i)); }); }); })
      .add_to(contact);
}

// The weights of the closest points, times n^2, are not negative, and |volume| = distance * |n|. Without a limit
// the volume has to be 0, which is necessary in any case.
template <class Features>
void add_planes_near(Contact& contact, const Features& features) {
  Draft draft(features);
  for (int i = 0; i < fixed::Sides<Features::kKind>::kCount; ++i)
    draft.not_negative([=](const auto& f) { return wide_dot(f.side(i), f.n()); });
  draft.not_zero([](const auto& f) { return wide_dot(f.n(), f.n()); });
  if (features.has_limit())
    draft.within([](const auto& f) { return limit_of(f) * wide_dot(f.n(), f.n()); },
                 [](const auto& f) { return f.volume() * f.volume(); },
                 [](const auto& use) { use([](const auto& f) { return f.volume(); }); });
  draft.add_to(contact);
}

// The points at the sides and, with a limit above 0, at their ends. Without one, a point at an end is on the side, too.
template <class Features>
void add_outline(Contact& contact, const Features& features) {
  for (int i = 0; i < fixed::Sides<Features::kKind>::kCount; ++i)
    if (features.has_limit())
      add_point_near_segment(contact, features, i);
    else
      add_point_on_segment(contact, features, i);
  if (features.has_limit())
    for (int i = 0; i < fixed::Differences<Features::kKind, 1>::kCount; ++i) add_point_near_point(contact, features, i);
}

/// True if the forms of an alternative are below 0 all along.
bool are_apart(const Contact& contact) {
  return std::any_of(contact.alternatives.begin(), contact.alternatives.end(), [](const std::vector<LazyForm>& forms) {
    return std::all_of(forms.begin(), forms.end(), [](const LazyForm& f) { return f.closed_sign() < 0; });
  });
}

// Adds that no axis keeps the features apart. These forms are lines, so they cost little, and where exponents lie far
// apart one coordinate mostly decides.
template <class Features>
void add_axes(Contact& contact, const Features& features) {
  kAxes([&](auto axis) {
    for (const bool is_above : {false, true}) {
      std::vector<LazyForm>& forms = contact.alternatives.emplace_back();
      for (int i = 0; i < fixed::Differences<Features::kKind, 1>::kCount; ++i)
        forms.push_back(features.form(
            [=](const auto& f) { return is_above ? f.limit() - axis(f.d(i)) : f.limit() + axis(f.d(i)); }));
    }
  });
}

// The weights of the vertex in the triangle are (B x C) n, (C x A) n and (A x B) n over n^2, and the volume is its
// height times |n|. Where no weight is negative, the distance is the height, else that to a side; a triangle without
// area is its sides. The closest points of two edges' lines have the weights (A x B) n of a1, (D x C) n of a0, (C x A)
// n of b1 and (B x D) n of b0, over n^2, and the volume is the lines' distance times |n|. Where a weight is negative or
// the edges are parallel, an end of one edge is among the closest points.
template <class Features>
Contact contact_of(const Features& features) {
  Contact contact;
  contact.numbers = features.numbers();
  if constexpr (!Features::kIsFixed) {
    add_axes(contact, features);
    if (are_apart(contact)) return contact;
  }
  if (!features.has_limit()) {
    contact.necessary = lazy(features.form([](const auto& f) { return f.volume(); }));
    if (contact.necessary.closed_sign() != 0) return contact;
  }
  add_planes_near(contact, features);
  add_outline(contact, features);
  return contact;
}

template <ContactKind kind, int degree>
std::vector<Contact> AnyNumbers<kind, degree>::cut(const RoughForm::Place& from, const RoughForm::Place& to) const {
  std::vector<Contact> contacts;
  if (const auto parts = motion_.cut(from, to))
    for (const RoughMotion& part : *parts) contacts.push_back(contact_of(OfAnySize<kind, degree>(part)));
  return contacts;
}

/// Makes the contact in numbers of W limbs, which the unit has to fit.
template <ContactKind kind, int W>
Contact fixed_contact(const fixed::Unit& unit, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                      const ContactDistance& limit) {
  using Linear = fixed::Polynomial<1, W>;
  const auto linear = [&](const auto& from, const auto& to) {
    return Linear{{unit.count<W>(from), unit.count<W>(to)}};
  };
  QueryOf<Linear> query{{}, linear(limit, limit)};
  for (size_t i = 0; i < 4; ++i) {
    const Vec3<double>&p = start[i], &q = end[i];
    query.points[i] = {linear(p.x, q.x), linear(p.y, q.y), linear(p.z, q.z)};
  }
  return contact_of(OfFixedSize<kind, W>(query));
}

template <ContactKind kind>
Contact contact_of_kind(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], const ContactDistance& limit) {
  fixed::Unit unit;
  unit.see(start);
  unit.see(end);
  unit.see(limit);
  if (unit.fits<1>()) return fixed_contact<kind, 1>(unit, start, end, limit);
  if (unit.fits<2>()) return fixed_contact<kind, 2>(unit, start, end, limit);
  return contact_of(OfAnySize<kind, 1>(Points(start, end, limit)));
}

template <int degree>
Contact any_contact(ContactKind kind, const Points& points) {
  return kind == ContactKind::kVertexTriangle ? contact_of(OfAnySize<ContactKind::kVertexTriangle, degree>(points))
                                              : contact_of(OfAnySize<ContactKind::kEdgeEdge, degree>(points));
}

}  // namespace

Contact contact_in_motion(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                          const ContactDistance& limit) {
  return kind == ContactKind::kVertexTriangle ? contact_of_kind<ContactKind::kVertexTriangle>(start, end, limit)
                                              : contact_of_kind<ContactKind::kEdgeEdge>(start, end, limit);
}

Contact contact_in_any_size(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                            const ContactDistance& limit) {
  return any_contact<1>(kind, Points(start, end, limit));
}

Contact contact_at_rest(ContactKind kind, const Vec3<double> (&p)[4], const ContactDistance& limit) {
  return any_contact<0>(kind, Points(p, p, limit));
}

}  // namespace collided::exact
