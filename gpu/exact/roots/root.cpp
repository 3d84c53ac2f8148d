#include "gpu/exact/roots/root.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "gpu/exact/poll.hpp"
#include "gpu/exact/roots/divisor.hpp"
#include "gpu/exact/roots/piece.hpp"

namespace collided::exact {
namespace {

constexpr mp_bitcnt_t kHalvingsFirst = 2;

/// A dyadic root in the middle of a piece is a piece of its own: f = 0 in degree 0, `on` starting at the root.
Piece middle_root(const Dyadic& whole) { return {Form(), {2 * whole.k + 1, whole.bits + 1}}; }

// Halving until Descartes' rule leaves one root or none in each piece (Collins and Akritas 1976); false if an interval
// of 2^-depth still has more. Intervals get short enough in the end if all roots are simple, but to make them so costs
// more than most halvings.
bool isolate(const Form& f, mp_bitcnt_t depth, std::vector<Root>& roots) {
  std::vector<Piece> left_to_right{{f, {}}};  // the leftmost piece last
  while (!left_to_right.empty()) {
    PollScope::step();
    const Piece piece = std::move(left_to_right.back());
    left_to_right.pop_back();
    const Dyadic& on = piece.on;
    const int changes = sign_changes(piece.f);
    if (piece.f.vanishes()) {
      roots.push_back(Root::at_point(on));
    } else if (changes == 1) {
      roots.push_back(Root::inside(f, on, first_sign(piece.f)));
    } else if (changes > 1) {
      if (on.bits >= depth) return false;
      if (on.bits >= kHalvingsFirst)
        if (std::optional<Piece> shorter = around_cluster(piece, changes)) {
          left_to_right.push_back(std::move(*shorter));
          continue;
        }
      left_to_right.push_back(right_half(piece));
      if (left_to_right.back().f.c.front().is_zero()) left_to_right.push_back(middle_root(on));
      left_to_right.push_back(left_half(piece));
    }
  }
  return true;
}

/// The root of c[0] s + c[1] t.
Root root_of_line(const Form& f) {
  const bool is_falling = sgn(f.c.front()) > 0;
  return Root::at_ratio(is_falling ? -f.c[1] : f.c[1], is_falling ? f.c[0] : -f.c[0]);
}

/// Returns the roots of a form that has several in one place.
std::vector<Root> roots_with_repeated(const Form& f) {
  constexpr mp_bitcnt_t kAnyDepth = std::numeric_limits<mp_bitcnt_t>::max();
  const Form simple = square_free(f);
  std::vector<Root> roots;
  if (simple.degree() == 1) {
    if (sign_changes(simple) == 1) roots.push_back(root_of_line(simple));
  } else {
    isolate(simple, kAnyDepth, roots);
    for (Root& root : roots) root.forget_rise();
  }
  return roots;
}

}  // namespace

Root Root::at_ratio(Number s, Number t) {
  Root root;
  root.s_ = std::move(s);
  root.t_ = std::move(t);
  return root;
}

Root Root::at_point(const Dyadic& at) { return at_ratio((Number(1) << at.bits) - at.k, at.k); }

Root Root::inside(const Form& f, const Dyadic& in, int left_sign) {
  Root root;
  root.f_ = f;
  root.at_ = in;
  root.left_sign_ = left_sign;
  root.may_rise_ = left_sign < 0;
  return root;
}

// Quadratic interval refinement (Abbott 2006): the secant guesses in which of 2^jump parts the root is, and signs tell
// whether it is. Guesses come true once the form is nearly a line, and each then brings twice the bits of the last.
void Root::refine(mp_bitcnt_t bits) {
  mp_bitcnt_t jump = 8;
  while (!is_ratio() && at_.bits < bits) {
    PollScope::step();
    jump = std::min(jump, bits - at_.bits);
    if (jump > 1 && narrow(jump)) {
      jump *= 2;
      continue;
    }
    halve();
    jump = std::max<mp_bitcnt_t>(jump / 2, 2);
  }
}

/// Whether the root is at the lower end of `point`, where the form has this sign.
bool Root::settle_at(const Dyadic& point, int sign) {
  if (sign != 0) return false;
  const bool may_rise = may_rise_;
  *this = at_point(point);
  may_rise_ = may_rise;
  return true;
}

void Root::halve() {
  const Dyadic middle{2 * at_.k + 1, at_.bits + 1};
  const int sign = sign_at_point(f_, middle);
  if (settle_at(middle, sign)) return;
  at_ = {sign == left_sign_ ? middle.k : middle.k - 1, middle.bits};
}

/// Shortens the interval by `bits` bits if the secant leads there.
bool Root::narrow(mp_bitcnt_t bits) {
  const Number low = value_at_point(f_, at_), high = value_at_point(f_, {at_.k + 1, at_.bits});
  if (sgn(low) * sgn(high) >= 0) return false;  // an end that is a root of its own
  const Number part = (low << bits) / (low - high);
  const Dyadic begin{(at_.k << bits) + part, at_.bits + bits}, end{begin.k + 1, begin.bits};
  const int at_begin = sign_at_point(f_, begin);
  if (settle_at(begin, at_begin)) return true;
  if (at_begin != left_sign_) return false;
  const int at_end = sign_at_point(f_, end);
  if (settle_at(end, at_end)) return true;
  if (at_end == left_sign_) return false;
  at_ = begin;
  return true;
}

// Coefficients of one sign on the interval settle it, and a sign that is not zero is found once the interval is short
// enough. A zero never is: it is a common root. The greatest common divisor divides f, so in the interval it has this
// number as a simple root or no root, and the parity of its sign changes tells which. Who asks has mostly tried double
// precision before, so that a zero is likely.
int Root::sign_of(const Form& g) {
  if (g.vanishes()) return 0;
  bool may_be_zero = true;
  for (;;) {
    if (is_ratio()) return sgn(value_at_ratio(g, s_, t_));
    if (const int sign = open_sign(restricted(g, at_))) return sign;
    if (std::exchange(may_be_zero, false) && sign_changes(restricted(common_divisor(f_, g), at_)) % 2 == 1) return 0;
    refine(std::max<mp_bitcnt_t>(16, 2 * at_.bits));
  }
}

double Root::rounded_down() {
  refine(kTimeBits);
  return rounded_time(is_ratio() ? Dyadic{(t_ << kTimeBits) / (s_ + t_), kTimeBits} : at_);
}

double rounded_time(const Dyadic& at) {
  const Number k = (at.k << kTimeBits) >> at.bits;
  return std::ldexp(k.to_double(), -static_cast<int>(kTimeBits));  // which truncates
}

std::vector<Root> roots_inside(const Form& form) {
  constexpr mp_bitcnt_t kUsualDepth = 64;
  const Form f = without_roots_at_ends(form);
  std::vector<Root> roots;
  if (f.degree() == 1) {
    if (sign_changes(f) == 1) roots.push_back(root_of_line(f));
  } else if (!isolate(f, kUsualDepth, roots)) {
    roots = roots_with_repeated(f);
  }
  return roots;
}

}  // namespace collided::exact
