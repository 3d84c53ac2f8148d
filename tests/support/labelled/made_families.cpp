#include "tests/support/labelled/made_families.hpp"

#include <cmath>

namespace collided::test {
namespace {

constexpr int kFrameSize = 6;

using Maker = std::function<Made(Dice&, QueryKind)>;

// --- Where features cross -------------------------------------------------------------------------------------------

Crossing inside(Dice& dice, QueryKind kind) {
  Crossing c{dice.fraction(0, 1, 5), dice.fraction(0, 1, 4), dice.fraction(0, 1, 4)};
  if (kind == QueryKind::kVertexTriangle && c.x + c.y > 1) c.x = 1 - c.x, c.y = 1 - c.y;
  return c;
}

bool meets(QueryKind kind, const Crossing& c) {
  return kind == QueryKind::kVertexTriangle ? in_triangle(c.x, c.y) : in_edge(c.x) && in_edge(c.y);
}

Crossing outside(Dice& dice, QueryKind kind) {
  Crossing c;
  do c = {dice.fraction(0, 1, 5), dice.fraction(-2, 2, 3), dice.fraction(-2, 2, 3)};
  while (meets(kind, c));
  return c;
}

Crossing anywhere(Dice& dice, QueryKind kind) { return dice.chance() ? inside(dice, kind) : outside(dice, kind); }

Crossing at_time(Crossing c, const mpq_class& t) {
  c.t = t;
  return c;
}

// On a side, at a corner or at an end; `beyond` puts it outside by that much.
Crossing on_boundary(Dice& dice, QueryKind kind, const mpq_class& beyond) {
  Crossing c = inside(dice, kind);
  if (dice.chance()) c.y = dice.between(0, 1);
  if (kind == QueryKind::kVertexTriangle && c.y == 1) c.y = 0;
  if (kind == QueryKind::kVertexTriangle && dice.chance())
    c.x = 1 - c.y + beyond;
  else
    c.x = -beyond;
  return c;
}

// --- Families -------------------------------------------------------------------------------------------------------

Made crossing(Dice& dice, QueryKind kind, const Frame3& f, const Crossing& c, bool deforms = true) {
  return kind == QueryKind::kVertexTriangle ? vertex_through_triangle(dice, f, c, deforms)
                                            : edge_through_edge(dice, f, c, deforms);
}

Made common_motion(Dice& dice, Made made) {
  made.move_all(dice.vector(8));
  made.add_velocity(dice.vector(4));
  return made;
}

Made ordinary(Dice& dice, QueryKind kind) {
  return common_motion(dice, crossing(dice, kind, frame(dice, kFrameSize), anywhere(dice, kind)));
}

Made generic_hit(Dice& dice, QueryKind kind) {
  return common_motion(dice, crossing(dice, kind, frame(dice, kFrameSize), inside(dice, kind)));
}

Made generic_miss(Dice& dice, QueryKind kind) {
  Crossing c = outside(dice, kind);
  if (dice.chance()) c = at_time(inside(dice, kind), dice.chance() ? mpq_class(33, 32) : mpq_class(-1, 32));
  return common_motion(dice, crossing(dice, kind, frame(dice, kFrameSize), c));
}

// Coplanar at the first or the last moment, in contact or not.
Made coplanar(Dice& dice, QueryKind kind) {
  return common_motion(
      dice, crossing(dice, kind, frame(dice, kFrameSize), at_time(anywhere(dice, kind), dice.between(0, 1))));
}

Made identically_coplanar(Dice& dice, QueryKind kind) {
  const Frame3 f = frame(dice, kFrameSize);
  const Crossing c{dice.fraction(0, 1, 5), dice.fraction(-1, 2, 3), 0};
  return common_motion(dice, kind == QueryKind::kVertexTriangle ? vertex_within_plane(f, c) : edge_within_plane(f, c));
}

// Nothing moves but all together: in contact from the start, or never, by as little as 2^-40 of the size.
Made standing_still(Dice& dice, QueryKind kind) {
  const Frame3 f = frame(dice, kFrameSize);
  Made made = crossing(dice, kind, f, at_time(anywhere(dice, kind), 0), false);
  const int off = dice.between(0, 2);
  const mpq_class height = off == 0 ? mpq_class(0) : off == 1 ? mpq_class(1, 4) : mpq_class(1, 1ul << 40);
  const int points = kind == QueryKind::kVertexTriangle ? 1 : 2;
  for (int i = 0; i < points; ++i) made.x[i] = made.x[i] + height * f.q;
  made.v = {};
  made.hit = made.hit && height == 0;
  made.move_all(dice.vector(8));
  return made;
}

Made common_translation(Dice& dice, QueryKind kind) {
  Made made = standing_still(dice, kind);
  made.add_velocity(dice.vector(1000));
  return made;
}

Maker contact_at(int t) {
  return [t](Dice& dice, QueryKind kind) {
    return common_motion(dice, crossing(dice, kind, frame(dice, kFrameSize), at_time(inside(dice, kind), t)));
  };
}

// Through a corner, a side or an end.
Made grazing(Dice& dice, QueryKind kind) {
  return common_motion(dice, crossing(dice, kind, frame(dice, kFrameSize), on_boundary(dice, kind, 0)));
}

// The smallest step outside that doubles can represent.
Made grazing_one_ulp_off(Dice& dice, QueryKind kind) {
  const uint64_t seed = dice.bits();
  Query query;
  Made made;
  for (int bits = 52; bits == 52 || !made.to_query(query); --bits) {
    Dice again(seed);
    made = crossing(again, kind, frame(again, kFrameSize), on_boundary(again, kind, mpq_class(1, 1ul << bits)), false);
  }
  return made;
}

// A double root, two roots close together, or barely none.
Made tangential(Dice& dice, QueryKind kind) {
  const mpq_class half = dice.chance() ? mpq_class(0) : mpq_class(1, 1ul << dice.between(3, 18));
  return common_motion(dice,
                       touching_turning(kind, frame(dice, 3), mpq_class(dice.between(2, 6), 8), half, dice.chance()));
}

Maker scaled_frame(int u, int w, int q) {
  return [u, w, q](Dice& dice, QueryKind kind) {
    Frame3 f = frame(dice, kFrameSize);
    const auto times = [](int exponent, const ExactVec& v) { return mpq_class(std::ldexp(1, exponent)) * v; };
    f = {times(u, f.u), times(w, f.w), times(q, f.q)};
    return crossing(dice, kind, f, anywhere(dice, kind), false);
  };
}

Made mixed_scale(Dice& dice, QueryKind kind) {
  return scaled_frame(dice.between(-16, 16), dice.between(-16, 16), dice.between(-16, 16))(dice, kind);
}

// The triangle is a segment or a point; or one edge is a point.
Made zero_area(Dice& dice, QueryKind kind) {
  const Frame3 f = frame(dice, kFrameSize);
  Made made;
  made.kind = kind;
  made.at = dice.fraction(0, 1, 5);
  const mpq_class x = dice.fraction(-1, 2, 2), third = dice.fraction(-1, 2, 2);
  made.x = {x * f.u, kind == QueryKind::kVertexTriangle ? ExactVec{} : x * f.u, {}, f.u};
  made.v = {f.q, kind == QueryKind::kVertexTriangle ? ExactVec{} : f.q, {}, {}};
  if (kind == QueryKind::kVertexTriangle) made.x[2] = third * f.u;
  const bool beyond = kind == QueryKind::kVertexTriangle && (third < 0   ? in_edge((x - third) / (1 - third))
                                                             : third > 0 ? in_edge(x / third)
                                                                         : false);
  made.hit = in_edge(x) || beyond;
  made.first = made.at;
  return common_motion(dice, made);
}

// Corners (or ends) in one place, and the other feature's point there at time t, or beside it.
Made duplicate_vertices(Dice& dice, QueryKind kind) {
  const Frame3 f = frame(dice, kFrameSize);
  Made made;
  made.kind = kind;
  made.at = dice.fraction(0, 1, 5);
  made.hit = dice.chance();
  made.first = made.at;
  const ExactVec point = mpq_class(made.hit ? 0 : 1) * f.u;
  const bool vertex = kind == QueryKind::kVertexTriangle;
  made.x = {point, vertex ? ExactVec{} : point, {}, {}};
  made.v = {f.q, vertex ? ExactVec{} : f.q, {}, {}};
  return common_motion(dice, made);
}

// A vertex of one feature is a vertex of the other at all times.
Made shared_vertex(Dice& dice, QueryKind kind) {
  Made made = generic_miss(dice, kind);
  const int shared = dice.between(kind == QueryKind::kVertexTriangle ? 1 : 2, 3);
  made.x[0] = made.x[shared];
  made.v[0] = made.v[shared];
  made.hit = true;
  made.first = 0;
  return made;
}

Made parallel(Dice& dice, QueryKind) {
  const Crossing c{dice.fraction(0, 1, 5), dice.fraction(-2, 3, 3), dice.fraction(-2, 3, 3)};
  return common_motion(dice, parallel_edges(dice, frame(dice, kFrameSize), c));
}

// Directions about 1e-9 apart.
Made near_parallel(Dice& dice, QueryKind kind) {
  Frame3 f = frame(dice, kFrameSize);
  f.w = f.u + mpq_class(1, 1ul << 30) * f.w;
  return crossing(dice, kind, f, anywhere(dice, kind), false);
}

Made far_translation(Dice& dice, QueryKind kind) {
  Made made = crossing(dice, kind, frame(dice, kFrameSize), anywhere(dice, kind));
  made.move_all(mpq_class(std::ldexp(1, dice.between(20, 36))) * dice.vector(8));
  return made;
}

Maker at_scale(int low, int high) {
  return [low, high](Dice& dice, QueryKind kind) {
    Made made = ordinary(dice, kind);
    made.scale(dice.between(low, high));
    return made;
  };
}

}  // namespace

const std::vector<MadeFamily>& made_families() {
  static const std::vector<MadeFamily> families{
      {"generic_hit", generic_hit},
      {"generic_miss", generic_miss},
      {"coplanar", coplanar},
      {"identically_coplanar", identically_coplanar},
      {"common_translation", common_translation},
      {"static", standing_still},
      {"contact_at_0", contact_at(0)},
      {"contact_at_1", contact_at(1)},
      {"grazing", grazing},
      {"grazing_one_ulp_off", grazing_one_ulp_off},
      {"tangential", tangential},
      {"needle", scaled_frame(0, -27, 0)},
      {"zero_area", zero_area},
      {"duplicate_vertices", duplicate_vertices},
      {"shared_vertex", shared_vertex},
      {"parallel_edges", parallel, true},
      {"near_parallel_edges", near_parallel, true},
      {"mixed_scale", mixed_scale},
      {"far_translation", far_translation},
      {"tiny_scale", at_scale(-900, -100)},
      {"huge_scale", at_scale(100, 900)},
      {"denormal", at_scale(-1062, -1058)},
  };
  return families;
}

}  // namespace collided::test
