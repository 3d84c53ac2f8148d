// Makes data/labelled_queries.csv anew, byte for byte:   make_labelled > tests/support/data/labelled_queries.csv
//
// Labels come from the construction ("made"); those of the families `random` and `lattice` from the exact judge
// ("judge"). The judge has to agree with every label that was made, or nothing is written.

#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <limits>
#include <sstream>

#include "tests/support/made_queries.hpp"

namespace collided::test {
namespace {

constexpr int kOfEachKind = 50;  // queries of each family
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

// The least step outside that doubles hold.
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

struct Family {
  const char* name;
  Maker make;
  bool edges_only = false;
};

const Family kFamilies[] = {
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

// --- Rows -----------------------------------------------------------------------------------------------------------

double at_least(const mpq_class& value) {
  const double below = value.get_d();  // cut towards zero
  return mpq_class(below) == value ? below : std::nextafter(below, std::numeric_limits<double>::infinity());
}

// A hex float as short as it can be: an odd integer times a power of two.
std::string hex(double value) {
  if (value == 0) return "0";
  int exponent = 0;
  auto digits = static_cast<long long>(std::ldexp(std::frexp(std::abs(value), &exponent), 53));
  exponent -= 53;
  for (; digits % 2 == 0; digits /= 2) ++exponent;
  char text[64];
  std::snprintf(text, sizeof text, "%s0x%llxp%d", value < 0 ? "-" : "", digits, exponent);
  return text;
}

void write_row(std::ostream& out, const std::string& family, const Query& query, const ExactImpact& label,
               const char* by) {
  out << family << (query.kind == QueryKind::kVertexTriangle ? ",vt," : ",ee,") << label.hit << ',';
  out << hex(label.hit ? label.lower.get_d() : 0) << ',' << hex(label.hit ? at_least(label.upper) : 1) << ',' << by;
  for (const Vec3d& point : query.p)
    for (const double coordinate : point) out << ',' << hex(coordinate);
  out << '\n';
}

bool judge_agrees(const Query& query, const Made& made) {
  const ExactImpact impact = judge_ccd(query);
  return impact.hit == made.hit && (!made.hit || (impact.lower <= made.first && made.first <= impact.upper));
}

// Returns how many labels the judge disagrees with.
int write_made(std::ostream& out, const Family& family, QueryKind kind, int count, Dice& dice) {
  int disagree = 0;
  while (count > 0) {
    const Made made = family.make(dice, kind);
    Query query;
    if (!made.to_query(query)) continue;
    --count;
    if (!judge_agrees(query, made)) ++disagree;
    write_row(out, family.name, query, {made.hit, made.first, made.first}, "made");
  }
  return disagree;
}

Query random_query(Dice& dice, QueryKind kind) {
  Query query{kind, {}};
  for (Vec3d& point : query.p)
    for (double& coordinate : point) coordinate = dice.real();
  return query;
}

Query lattice_query(Dice& dice, QueryKind kind) {
  Query query{kind, {}};
  for (Vec3d& point : query.p)
    for (double& coordinate : point) coordinate = dice.between(-2, 2);
  return query;
}

// As many hits as misses, labelled by the judge.
void write_judged(std::ostream& out, const char* family, const std::function<Query(Dice&, QueryKind)>& make,
                  QueryKind kind, Dice& dice) {
  int wanted[] = {kOfEachKind / 2, kOfEachKind / 2};
  while (wanted[0] + wanted[1] > 0) {
    const Query query = make(dice, kind);
    const ExactImpact impact = judge_ccd(query);
    if (wanted[impact.hit] == 0) continue;
    --wanted[impact.hit];
    write_row(out, family, query, impact, "judge");
  }
}

int write_set(std::ostream& out) {
  out << "family,kind,hit,toi_lower,toi_upper,by,x y z of each of the 8 points\n";
  Dice dice(2026);
  int disagree = 0;
  constexpr QueryKind kKinds[] = {QueryKind::kVertexTriangle, QueryKind::kEdgeEdge};
  for (const Family& family : kFamilies) {
    int wrong = 0;
    for (const QueryKind kind : kKinds)
      if (kind == QueryKind::kEdgeEdge || !family.edges_only)
        wrong += write_made(out, family, kind, family.edges_only ? 2 * kOfEachKind : kOfEachKind, dice);
    if (wrong) std::cerr << family.name << ": the judge disagrees with " << wrong << '\n';
    disagree += wrong;
  }
  for (const QueryKind kind : kKinds) write_judged(out, "random", random_query, kind, dice);
  for (const QueryKind kind : kKinds) write_judged(out, "lattice", lattice_query, kind, dice);
  return disagree;
}

}  // namespace
}  // namespace collided::test

int main() {
  std::ostringstream rows;
  if (collided::test::write_set(rows) > 0) return 1;
  std::cout << rows.str();
  return 0;
}
