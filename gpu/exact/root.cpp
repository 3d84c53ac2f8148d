#include "gpu/exact/root.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "gpu/exact/divisor.hpp"
#include "gpu/exact/poll.hpp"

namespace collided::exact {
namespace {

constexpr mp_bitcnt_t kTimeBits = 60;

struct Piece {
  Form f;  ///< in the local parameter of `on`
  Dyadic on;
};

/// A dyadic root in the middle of a piece is a piece of its own: f = 0 in degree 0, `on` starting at the root.
Piece middle_root(const Dyadic& whole) { return {Form(), {2 * whole.k + 1, whole.bits + 1}}; }

// Halving until Descartes' rule leaves one root or none in each piece (Collins and Akritas 1976); false if `depth`
// halvings do not do. They do in the end if all roots are simple, but to make them so costs more than most halvings.
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
      if (on.bits == depth) return false;
      const Dyadic left{2 * on.k, on.bits + 1}, right{2 * on.k + 1, on.bits + 1};
      left_to_right.push_back({right_half(piece.f), right});
      if (left_to_right.back().f.c.front() == 0) left_to_right.push_back(middle_root(on));
      left_to_right.push_back({left_half(piece.f), left});
    }
  }
  return true;
}

}  // namespace

Root Root::at_point(const Dyadic& at) {
  Root root;
  root.at_ = at;
  return root;
}

Root Root::inside(const Form& f, const Dyadic& in, int left_sign) {
  Root root;
  root.f_ = f;
  root.at_ = in;
  root.left_sign_ = left_sign;
  return root;
}

// Quadratic interval refinement (Abbott 2006): the secant guesses in which of 2^jump parts the root is, and signs tell
// whether it is. Guesses come true once the form is nearly a line, and each then brings twice the bits of the last.
void Root::refine(mp_bitcnt_t bits) {
  mp_bitcnt_t jump = 2;
  while (left_sign_ != 0 && at_.bits < bits) {
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
  at_ = point;
  left_sign_ = 0;
  return true;
}

void Root::halve() {
  const Dyadic middle{2 * at_.k + 1, at_.bits + 1};
  const int sign = sign_at_point(f_, middle);
  if (settle_at(middle, sign)) return;
  at_ = {sign == left_sign_ ? middle.k : mpz_class(middle.k - 1), middle.bits};
}

/// Shortens the interval by `bits` bits if the secant leads there.
bool Root::narrow(mp_bitcnt_t bits) {
  const mpz_class low = value_at_point(f_, at_), high = value_at_point(f_, {at_.k + 1, at_.bits});
  if (sgn(low) * sgn(high) >= 0) return false;  // an end that is a root of its own
  const mpz_class part = (low << bits) / mpz_class(low - high);
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
// number as a simple root or no root, and the parity of its sign changes tells which.
int Root::sign_of(const Form& g) {
  if (g.vanishes()) return 0;
  constexpr mp_bitcnt_t kDivisorAt = 64;  // rarely reached but by zeros
  bool may_be_zero = true;
  for (mp_bitcnt_t bits = 4;; bits *= bits < kDivisorAt ? 4 : 2) {
    if (left_sign_ == 0) return sign_at_point(g, at_);
    if (const int sign = open_sign(restricted(g, at_))) return sign;
    if (bits > kDivisorAt && std::exchange(may_be_zero, false))
      if (sign_changes(restricted(common_divisor(f_, g), at_)) % 2 == 1) return 0;
    refine(bits);
  }
}

double Root::rounded_down() {
  refine(kTimeBits);
  mpz_class k = at_.k << kTimeBits;
  k >>= at_.bits;
  return std::ldexp(k.get_d(), -static_cast<int>(kTimeBits));  // get_d() truncates
}

std::vector<Root> roots_inside(const Form& f) {
  constexpr mp_bitcnt_t kUsualDepth = 12, kAnyDepth = std::numeric_limits<mp_bitcnt_t>::max();
  std::vector<Root> roots;
  if (!isolate(f, kUsualDepth, roots)) {
    roots.clear();
    isolate(square_free(f), kAnyDepth, roots);
  }
  return roots;
}

}  // namespace collided::exact
