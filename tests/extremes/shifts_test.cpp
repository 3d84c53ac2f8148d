// Invariances. Far away, or in another unit of length, a query gets the same verdict as at the origin: moving by
// integers and scaling by powers of two rounds nothing here. And whatever else is in the scene, nothing is missed.

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/support/families/query_families_shapes.hpp"
#include "tests/support/verdicts/verdict_score_checks.hpp"

namespace collided::test {
namespace {

constexpr uint64_t kQueries = 300;

struct Shift {
  Vec3d by{};
  int exponent = 0;
};

Query shifted(Query query, const Shift& shift) {
  for (Vec3d& p : query.p)
    for (size_t axis = 0; axis < 3; ++axis) p[axis] = std::ldexp(p[axis] + shift.by[axis], shift.exponent);
  return query;
}

struct Tolerances {
  double delta, thickness;
};

class Shifts : public OnBackend<::testing::TestWithParam<std::tuple<Scalar, Accuracy>>> {
 protected:
  static Scalar scalar() { return std::get<0>(GetParam()); }

  static std::vector<Verdict> run(const std::vector<Query>& queries, const Tolerances& tolerances, int exponent) {
    BatchSettings settings;
    settings.backend = kBackend;
    settings.scalar = scalar();
    settings.accuracy = std::get<1>(GetParam());
    settings.delta = std::ldexp(tolerances.delta, exponent);
    settings.thickness = std::ldexp(tolerances.thickness, exponent);
    return run_queries(queries, settings);
  }

  static void expect_same(const std::vector<Query>& queries, const Tolerances& tolerances, const Shift& shift) {
    std::vector<Query> moved;
    for (const Query& query : queries) moved.push_back(shifted(query, shift));
    const std::vector<Verdict> here = run(queries, tolerances, 0), there = run(moved, tolerances, shift.exponent);
    for (size_t i = 0; i < queries.size(); ++i) {
      const bool same = here[i].hit == there[i].hit && here[i].toi == there[i].toi && here[i].flags == there[i].flags;
      EXPECT_TRUE(same) << "query " << i << ": " << text_of(here[i]) << "; moved: " << text_of(there[i]) << "\n  "
                        << text_of(queries[i]);
    }
  }

  static void expect_same_everywhere(const QueryFamily& family, const std::vector<Shift>& shifts) {
    for (QueryKind kind : kQueryKinds) {
      const std::vector<Query> queries = queries_of({&family, kind, scalar(), 3}, kQueries);
      for (const Tolerances& tolerances : {Tolerances{0, 0}, Tolerances{0x1p-7, 0}, Tolerances{0, 0x1p-2}})
        for (const Shift& shift : shifts) expect_same(queries, tolerances, shift);
    }
  }
};

TEST_P(Shifts, TranslationsOfIntegersChangeNothing) {
  const double far = scalar() == Scalar::kF32 ? 0x1p20 : 0x1p45;
  expect_same_everywhere(fuzz_family("lattice"), {{{1, -2, 3}, 0}, {{far, 0, -far}, 0}, {{-far, far, far}, 0}});
}

TEST_P(Shifts, ScalesOfPowersOfTwoChangeNothing) {
  // Scenes whose size is not a float do without the coplanarity filter, which may leave more false hits.
  const int far = scalar() == Scalar::kF32 ? 80 : 110;
  for (const char* name : {"lattice", "aimed"})
    expect_same_everywhere(fuzz_family(name), {{{}, 1}, {{}, -7}, {{}, far}, {{}, -far}});
}

// A lattice whose axes have units so far apart that products of floats underflow on the way to ordinary ones.
Query flat_lattice(QueryKind kind, Scalar, Random& random) {
  Query query = play(exact_touch(kind, random, eighths(random)));
  for (Vec3d& p : query.p) p = {0x1p-128 * p[0], 0x1p104 * p[1], 0x1p-70 * p[2]};
  return turned(query, random);
}

// A lattice so small that its volume is about the smallest float.
Query tiny_lattice(QueryKind kind, Scalar, Random& random) {
  Query query = play(exact_touch(kind, random, eighths(random)));
  const int x = random.integer(-60, -45), y = random.integer(-60, -45), z = random.integer(-170, -150) - x - y;
  for (Vec3d& p : query.p) p = {std::ldexp(p[0], x), std::ldexp(p[1], y), std::ldexp(p[2], z)};
  return query;
}

// The scene is scaled by its size, which a neighbour of `size` determines.
void expect_found_beside(const QuerySource& source, double size,
                         const std::function<std::vector<Verdict>(const std::vector<Query>&)>& run, Accuracy accuracy) {
  std::vector<Query> queries = queries_of(source, 2000);
  Query neighbour = queries[0];
  neighbour.p[0][0] = size;
  queries.push_back(neighbour);
  const Judged truth = judge(std::move(queries), Mode::kCcd, 0);
  std::vector<Offence> offences;
  score(truth, run(truth.queries), accuracy, &offences);
  EXPECT_EQ(offences.size(), 0u);
  for (size_t i = 0; i < std::min<size_t>(offences.size(), 3); ++i)
    ADD_FAILURE() << offences[i].what << ": " << text_of(truth.queries[offences[i].query]);
}

TEST_P(Shifts, ANeighbourHidesNothing) {
  const QueryFamily flat{"flat lattice", flat_lattice}, tiny{"tiny lattice", tiny_lattice};
  const auto ask = [](const std::vector<Query>& queries) { return run(queries, {0, 0}, 0); };
  const auto [scalar, accuracy] = GetParam();
  for (QueryKind kind : kQueryKinds) {
    expect_found_beside({&flat, kind, scalar, 4}, scalar == Scalar::kF32 ? 0x1p124 : 0x1p1020, ask, accuracy);
    expect_found_beside({&tiny, kind, scalar, 4}, 1, ask, accuracy);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Levels, Shifts,
    ::testing::Combine(::testing::Values(Scalar::kF32, Scalar::kF64),
                       ::testing::Values(Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact)),
    [](const auto& info) { return name_of(std::get<0>(info.param)) + "_" + name_of(std::get<1>(info.param)); });

}  // namespace
}  // namespace collided::test
