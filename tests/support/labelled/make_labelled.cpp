// Regenerates our own set of queries, byte for byte:   make_labelled > tests/support/data/labelled_queries.csv
//
// Labels come from the construction ("made"); those of the families `random` and `lattice` from the exact judge
// ("judge"). Unless the judge agrees with every constructed label, nothing is written.

#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <sstream>

#include "tests/support/labelled/made_families.hpp"

namespace collided::test {
namespace {

constexpr int kOfEachKind = 50;  // queries of each family

double at_least(const mpq_class& value) {
  const double below = value.get_d();  // truncated towards zero
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
int write_made(std::ostream& out, const MadeFamily& family, QueryKind kind, int count, Dice& dice) {
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
  for (const MadeFamily& family : made_families()) {
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
