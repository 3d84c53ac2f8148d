#include "gpu/exact/roots/piece.hpp"

#include <algorithm>
#include <utility>

namespace collided::exact {
namespace {

/// The piece around the place where a root of this multiplicity would be, seen from one end by Newton's method.
std::optional<Piece> around_guess(const Piece& piece, int multiplicity, bool from_end) {
  const auto& c = piece.f.c;
  const Number degree = static_cast<int64_t>(piece.f.degree());
  const Number& value = from_end ? c.back() : c.front();
  const Number slope = degree * value - (from_end ? c[c.size() - 2] : c[1]);
  if (slope.is_zero()) return std::nullopt;
  const Number way = ((value * multiplicity) << piece.jump) / slope, whole = Number(1) << piece.jump;
  const Number guess = from_end ? whole - way - 1 : way;
  const Number k = sgn(guess) < 0 ? Number() : sgn(guess - whole) < 0 ? guess : whole - 1;
  const Dyadic on{(piece.on.k << piece.jump) + k, piece.on.bits + piece.jump};
  return Piece{restricted(piece.f, {k, piece.jump}), on, 2 * piece.jump};
}

mp_bitcnt_t shorter_jump(const Piece& piece) { return std::max<mp_bitcnt_t>(4, piece.jump / 2); }

}  // namespace

Piece left_half(const Piece& piece) {
  return {left_half(piece.f), {2 * piece.on.k, piece.on.bits + 1}, shorter_jump(piece)};
}
Piece right_half(const Piece& piece) {
  return {right_half(piece.f), {2 * piece.on.k + 1, piece.on.bits + 1}, shorter_jump(piece)};
}

// The idea is Sagraloff and Mehlhorn's (2016). By Descartes' rule nothing is left out if all changes of sign are in the
// shorter piece.
std::optional<Piece> around_cluster(const Piece& piece, int changes) {
  for (const bool from_end : {false, true}) {
    std::optional<Piece> shorter = around_guess(piece, changes, from_end);
    if (shorter && sign_changes(shorter->f) == changes) return shorter;
  }
  return std::nullopt;
}

}  // namespace collided::exact
