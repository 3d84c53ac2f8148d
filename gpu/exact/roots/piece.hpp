#pragma once
// Parts of [0, 1] in which roots of a form are looked for.

#include <optional>

#include "gpu/exact/form.hpp"

namespace collided::exact {

struct Piece {
  Form f;  ///< in the local parameter of `on`
  Dyadic on;
  mp_bitcnt_t jump = 4;  ///< bits by which to shorten the interval at once
};

Piece left_half(const Piece& piece);
Piece right_half(const Piece& piece);

/// A much shorter piece that has all the roots of the piece's form, of which there are `changes` at most; none if there
/// is no such cluster of roots.
std::optional<Piece> around_cluster(const Piece& piece, int changes);

}  // namespace collided::exact
