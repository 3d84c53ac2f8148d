// Pairs that limit a way are those that would break their floors on all of it. Integer arithmetic judges that over all
// pairs of small scenes, with floors from distances of its own.

#include <algorithm>
#include <cstdio>

#include "tests/gpu/refused_field.hpp"
#include "tests/gpu/scene/step_cases.hpp"
#include "tests/gpu/shards/one_and_shards.hpp"
#include "tests/support/distance.hpp"
#include "tests/support/judge/exact_judge.hpp"

namespace collided::test {
namespace {

/// A step of a small scene.
struct Step {
  StepScene scene;
  std::vector<Vec3d> x, p;
  double m;

  template <class Real>
  static Step any(uint64_t seed, double least_exponent) {
    Random random(seed);
    Step step{placed_scene(seed, least_exponent), {}, {}, seed % 5 == 0 ? 0 : seed % 2 == 0 ? 1e-4 : 1e-3};
    step.x = rounded_to<Real>(step.scene.positions);
    step.p = any_target<Real>(step.scene, step.x, 1, random);
    return step;
  }
};

std::unique_ptr<Detector> at_start(const Step& step, SceneSpec spec) {
  spec.min_separation = step.m;
  const Case at_rest = case_of(step.scene, step.x, step.x);
  auto detector = Detector::create(spec_for(at_rest, spec));
  detector->detect(Frame(at_rest, Mode::kCcd, spec.scalar).input());
  return detector;
}
FrameResult advance(Detector& detector, const Step& step, AdvanceMode mode, bool limits = true, bool trial = true) {
  const Frame frame(case_of(step.scene, step.x, step.p), Mode::kDcd, detector.spec().scalar, false);
  FrameInput input = frame.input();
  input.advance = true, input.advance_mode = mode, input.limits = limits, input.trial = trial;
  return detector.detect(input);
}

bool are_the_same(const PerKind<ContactSet>& a, const PerKind<ContactSet>& b) {
  return same_bytes(a.vertex_triangle, b.vertex_triangle) && same_bytes(a.edge_edge, b.edge_edge) &&
         same_bytes(a.triangle_triangle, b.triangle_triangle);
}

/// A pair of features, and what is known of it without the engine.
struct Pair {
  QueryKind kind;
  std::array<uint32_t, 2> elements;
  std::array<uint32_t, 4> v;
  double start = 0, extent = 0;  ///< distance at the start; greatest of the differences of its vertices
};

/// All pairs of a scene that may touch, with the floors that the step gives them.
class AllPairs {
 public:
  AllPairs(const Step& step, const Topology& topology) : step_(step) {
    list_neighbours(topology);
    for (uint32_t v = 0; v < step.x.size(); ++v)
      for (uint32_t t = 0; t < topology.triangles.size(); ++t) {
        const auto& [a, b, c] = topology.triangles[t];
        add({QueryKind::kVertexTriangle, {v, t}, {v, a, b, c}});
      }
    for (uint32_t i = 0; i < topology.edges.size(); ++i)
      for (uint32_t j = i + 1; j < topology.edges.size(); ++j) {
        const auto &a = topology.edges[i], &b = topology.edges[j];
        add({QueryKind::kEdgeEdge, {i, j}, {a[0], a[1], b[0], b[1]}});
      }
    find_clearances();
  }

  const std::vector<Pair>& pairs() const { return pairs_; }
  /// Returns min(m, distance at the start, clearance).
  double floor_of(const Pair& pair) const {
    double clearance = HUGE_VAL;
    for (const uint32_t v : pair.v) clearance = std::min(clearance, clearances_[v]);
    return std::min({reach(), pair.start, std::max(clearance, 4 * theta())});
  }
  /// True if certificates say too little about the pair.
  bool is_tiny(const Pair& pair) const { return pair.start < 0x1p-33 * pair.extent; }
  Query way_of(const Pair& pair) const {
    Query query{pair.kind, {}};
    for (size_t i = 0; i < 4; ++i) query.p[i] = step_.x[pair.v[i]], query.p[i + 4] = step_.p[pair.v[i]];
    return query;
  }
  /// True if the boxes of both features' ways are within reach.
  bool may_come_near(const Pair& pair) const {
    const Query way = way_of(pair);
    const size_t first = pair.kind == QueryKind::kVertexTriangle ? 1 : 2;
    for (size_t k = 0; k < 3; ++k) {
      double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
      for (size_t i = 0; i < 8; ++i) {
        const bool second = i % 4 >= first;
        low[second] = std::min(low[second], way.p[i][k]), high[second] = std::max(high[second], way.p[i][k]);
      }
      if (low[0] - high[1] > reach() || low[1] - high[0] > reach()) return false;
    }
    return true;
  }

 private:
  double extent() const {
    double extent = 0;
    for (size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::ranges::minmax(step_.x, {}, [k](const Vec3d& p) { return p[k]; });
      extent = std::max(extent, high[k] - low[k]);
    }
    return extent;
  }
  double theta() const { return 0x1p-34 * std::exp2(std::ceil(std::log2(extent()))); }
  double reach() const { return std::max(step_.m, 4 * theta()); }
  bool is_static(uint32_t v) const { return step_.scene.is_static[step_.scene.mesh[v]]; }
  void list_neighbours(const Topology& topology) {
    for (const auto& [a, b] : topology.edges) joined_.insert({a, b}), joined_.insert({b, a});
  }
  template <class Test>
  static bool any_across(const Pair& pair, const Test& test) {
    const size_t first = pair.kind == QueryKind::kVertexTriangle ? 1 : 2;
    for (size_t i = 0; i < first; ++i)
      for (size_t j = first; j < 4; ++j)
        if (test(pair.v[i], pair.v[j])) return true;
    return false;
  }
  void add(Pair pair) {
    if (any_across(pair, [](uint32_t a, uint32_t b) { return a == b; })) return;
    if (is_static(pair.v[0]) && is_static(pair.v[3])) return;
    const std::array<Vec3d, 4> p{step_.x[pair.v[0]], step_.x[pair.v[1]], step_.x[pair.v[2]], step_.x[pair.v[3]]};
    pair.start = pair.kind == QueryKind::kVertexTriangle ? point_triangle(p[0], {p[1], p[2], p[3]}).distance
                                                         : edge_edge({p[0], p[1]}, {p[2], p[3]}).distance;
    for (const Vec3d& a : p)
      for (const Vec3d& b : p)
        for (size_t k = 0; k < 3; ++k) pair.extent = std::max(pair.extent, std::abs(a[k] - b[k]));
    pairs_.push_back(pair);
  }
  void find_clearances() {
    clearances_.assign(step_.x.size(), HUGE_VAL);
    for (const Pair& pair : pairs_) {
      if (any_across(pair, [&](uint32_t a, uint32_t b) { return joined_.contains({a, b}); })) continue;
      for (const uint32_t v : pair.v)
        if (!is_static(v)) clearances_[v] = std::min(clearances_[v], pair.start);
    }
  }

  const Step& step_;
  std::set<std::pair<uint32_t, uint32_t>> joined_;
  std::vector<Pair> pairs_;
  std::vector<double> clearances_;  ///< of each vertex; HUGE_VAL of those that stand
};

/// Counts what was judged.
struct Judged {
  size_t limits = 0, tiny = 0, must = 0, must_not = 0, on_the_way = 0, certified = 0;
};

std::array<Vec3d, 4> end_of(const Query& way) { return {way.p[4], way.p[5], way.p[6], way.p[7]}; }

/// True if the pair ends nearer than `floor`, or comes nearer than 7/8 of it on the way.
bool breaks(const Query& way, double floor) {
  return judge_proximity(way.kind, end_of(way), floor) || judge_ccd(way, 7.0 / 8 * floor).hit;
}

/// Judges the time, the points and the direction of a pair that is limited by its floor.
void expect_contact_at_floor(const Query& way, double floor, const ContactSet& set, size_t i) {
  const double t = set.toi[i];
  ASSERT_GE(t, 0);
  ASSERT_LE(t, 1);
  std::array<Vec3d, 4> at;
  for (size_t k = 0; k < 4; ++k) at[k] = lerp(way.p[k], way.p[k + 4], t);
  const auto [w0, w1] = set.weights[i];
  const bool is_vertex = way.kind == QueryKind::kVertexTriangle;
  const Vec3d first = is_vertex ? at[0] : lerp(at[0], at[1], w0);
  const Vec3d second = is_vertex ? point_of({at[1], at[2], at[3]}, {w0, w1}) : lerp(at[2], at[3], w1);
  const double distance = is_vertex ? point_triangle(at[0], {at[1], at[2], at[3]}).distance
                                    : edge_edge({at[0], at[1]}, {at[2], at[3]}).distance;
  EXPECT_NEAR(length_between(first, second), distance, 1e-12) << "closest points";
  const Vec3d gap = minus(first, second);
  double along = 0;
  for (size_t k = 0; k < 3; ++k) along += gap[k] * set.normals[i][k];
  EXPECT_NEAR(along, distance, 1e-6 * distance + 1e-14) << "the normal is along the gap";
  if (t > 0) {
    const ExactImpact first_time = judge_ccd(way, floor * (1 - 1e-12));
    const ExactImpact early = judge_ccd(way, floor * (1 + 1e-6) + 1e-13);
    EXPECT_TRUE(!first_time.hit || t <= first_time.upper) << "late";
    ASSERT_TRUE(early.hit);
    EXPECT_GE(t, early.lower.get_d() - 1e-12) << "far too early";
  }
}

void judge(const AllPairs& all, const FrameResult& result, Judged& judged) {
  constexpr double kLess = 1 - 1e-6, kMore = 1 + 1e-6;
  size_t next[2] = {0, 0};
  for (const Pair& pair : all.pairs()) {  // in canonical order
    const bool is_vertex = pair.kind == QueryKind::kVertexTriangle;
    const ContactSet& set = is_vertex ? result.limits.vertex_triangle : result.limits.edge_edge;
    size_t& i = next[is_vertex ? 0 : 1];
    const bool is_limit = i < set.size() && set.elements[i] == pair.elements;
    const double floor = all.floor_of(pair);
    const Query way = all.way_of(pair);
    SCOPED_TRACE((is_vertex ? "vertex-triangle " : "edge-edge ") + std::to_string(pair.elements[0]) + ", " +
                 std::to_string(pair.elements[1]) + ", floor " + std::to_string(floor));
    if (all.may_come_near(pair) && !all.is_tiny(pair)) {
      const bool must = breaks(way, floor * kLess), may = must || breaks(way, floor * kMore);
      EXPECT_TRUE(!must || is_limit) << "missing";
      EXPECT_TRUE(may || !is_limit) << "does not break its floor";
      judged.must += must, judged.must_not += !may;
    }
    if (all.may_come_near(pair) && all.is_tiny(pair)) {
      const ExactImpact touch = judge_ccd(way);
      EXPECT_TRUE(is_limit || !touch.hit || touch.lower == 0) << "touches after the start";
    }
    if (!is_limit) continue;
    EXPECT_TRUE(all.may_come_near(pair));
    EXPECT_NEAR(set.distance[i], floor, 1e-9 * floor + 1e-14);
    EXPECT_EQ((set.flags[i] & kFlagCertified) != 0, (set.flags[i] & kFlagNear) == 0);
    const bool is_tiny = all.is_tiny(pair), is_certified = (set.flags[i] & kFlagCertified) != 0;
    EXPECT_TRUE(!is_tiny || set.toi[i] == 0);
    if (!is_tiny) expect_contact_at_floor(way, set.distance[i], set, i);
    EXPECT_TRUE((set.flags[i] & kFlagInitial) == 0 || set.toi[i] == 0);
    EXPECT_TRUE(!is_certified || judge_ccd(way, set.distance[i]).hit);
    judged.tiny += is_tiny, judged.on_the_way += set.toi[i] > 0, judged.certified += is_certified;
    ++judged.limits, ++i;
  }
  EXPECT_EQ(next[0], result.limits.vertex_triangle.size()) << "order, or no pair of the scene";
  EXPECT_EQ(next[1], result.limits.edge_edge.size()) << "order, or no pair of the scene";
  EXPECT_EQ(result.limits.triangle_triangle.size(), 0u);
  EXPECT_EQ(count_contacts(result.limits) > 0, *result.advanced < 1);
}

class Limits : public OnBackend<::testing::Test> {};

TEST_F(Limits, AreThePairsThatTheWholeWayWouldBreakAndNoOthers) {
  Judged judged;
  for (uint64_t seed = 1; seed <= 120; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Step step = Step::any<double>(seed, -6);
    const auto detector = at_start(step, settings(Mode::kCcd, Accuracy::kCertified));
    judge(AllPairs(step, detector->topology()), advance(*detector, step, AdvanceMode::kPerVertex), judged);
  }
  std::printf("limits %zu, of which tiny %zu, on the way %zu, certified %zu; must %zu, must not %zu\n", judged.limits,
              judged.tiny, judged.on_the_way, judged.certified, judged.must, judged.must_not);
  EXPECT_GT(judged.must, 300u);
  EXPECT_GT(judged.must_not, 300u);
  EXPECT_GT(judged.tiny, 10u);
  EXPECT_GT(judged.on_the_way, 100u);
  EXPECT_GT(judged.certified, 100u);
}

// They are asked for twice in each mode, because a GPU then runs recorded steps.
TEST_F(Limits, AreTheSameHoweverTheyAreFound) {
  size_t limits = 0;
  for (uint64_t seed = 51; seed <= 62; ++seed)
    for (const Scalar scalar : {Scalar::kF64, Scalar::kF32}) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      const Step step = scalar == Scalar::kF64 ? Step::any<double>(seed, -8) : Step::any<float>(seed, -5);
      SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
      spec.scalar = scalar, spec.threads = 1;
      const FrameResult expected = advance(*at_start(step, spec), step, AdvanceMode::kAllOrOne);
      limits += count_contacts(expected.limits);
      for (const size_t shards : {0, 1, 2, 3})
        for (const Engine engine : {Engine::kAuto, Engine::kUniformGrid, Engine::kAllPairs}) {
          spec.engine = engine, spec.threads = 3;
          spec.accuracy = engine == Engine::kAllPairs ? Accuracy::kExact : Accuracy::kCertified;
          const auto detector = at_start(step, shards > 0 ? in_parts(spec, shards) : spec);
          for (const AdvanceMode mode : kModes) {
            EXPECT_TRUE(are_the_same(advance(*detector, step, mode).limits, expected.limits));
            EXPECT_TRUE(are_the_same(advance(*detector, step, mode).limits, expected.limits)) << "again";
          }
        }
    }
  EXPECT_GT(limits, 200u);
}

/// Two sheets of many vertices that go into each other.
Step pressed_sheets(uint32_t n) {
  Step step{{}, {}, {}, 1e-3};
  add(step.scene, sheet(n, 1, {0, 0, 0}));
  add(step.scene, sheet(n, 1, {0.003, 0.004, 0.02}));
  step.x = step.p = step.scene.positions;
  for (size_t v = step.p.size() / 2; v < step.p.size(); ++v)
    step.p[v][2] -= 0.03 + 0.01 * std::sin(40 * step.p[v][0]) * std::cos(30 * step.p[v][1]);
  return step;
}

TEST_F(Limits, AreInOrderHoweverManyTheyAre) {
  const SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
  const Step step = pressed_sheets(40);
  const FrameResult result = advance(*at_start(step, spec), step, AdvanceMode::kPerVertex);
  EXPECT_GT(count_contacts(result.limits), 5000u);
  for (const ContactSet* set : {&result.limits.vertex_triangle, &result.limits.edge_edge}) {
    EXPECT_GT(set->size(), 1000u);
    EXPECT_TRUE(std::ranges::is_sorted(set->elements));
    EXPECT_EQ(std::ranges::adjacent_find(set->elements), set->elements.end());
  }
  const FrameResult in_shards = advance(*at_start(step, in_parts(spec, 3)), step, AdvanceMode::kPerVertex);
  EXPECT_TRUE(are_the_same(in_shards.limits, result.limits));
}

uint64_t bytes_of(const Detector& detector) {
  uint64_t bytes = 0;
  for (const MemoryPart& part : detector.memory()) bytes += part.bytes;
  return bytes;
}

TEST_F(Limits, CostNothingWhereNobodyAsks) {
  const Step step = pressed_sheets(20);
  const auto detector = at_start(step, settings(Mode::kCcd, Accuracy::kCertified));
  for (int frame = 0; frame < 2; ++frame) advance(*detector, step, AdvanceMode::kPerVertex, false);
  const uint64_t before = bytes_of(*detector);
  const FrameResult without = advance(*detector, step, AdvanceMode::kPerVertex, false);
  EXPECT_EQ(count_contacts(without.limits), 0u);
  EXPECT_EQ(bytes_of(*detector), before);
  const FrameResult with = advance(*detector, step, AdvanceMode::kPerVertex);
  EXPECT_GT(count_contacts(with.limits), 100u);
  EXPECT_GT(bytes_of(*detector), before);
  EXPECT_EQ(digest(with), digest(without));
  EXPECT_EQ(with.advanced, without.advanced);
  EXPECT_EQ(with.way, without.way);
  EXPECT_EQ(with.shortened.ids, without.shortened.ids);
  EXPECT_EQ(with.shortened.fractions, without.shortened.fractions);
}

TEST_F(Limits, AreNoneWhereAllGoesAllTheWay) {
  Step step = pressed_sheets(4);
  step.p = step.x;
  for (Vec3d& p : step.p) p = plus(p, {0.25, 0.5, -1});
  const FrameResult result =
      advance(*at_start(step, settings(Mode::kCcd, Accuracy::kCertified)), step, AdvanceMode::kPerVertex, true, false);
  EXPECT_EQ(result.advanced, 1);
  EXPECT_EQ(count_contacts(result.limits), 0u);
}

TEST_F(Limits, NeedAFrameThatAdvances) {
  const Step step = pressed_sheets(3);
  const auto detector = at_start(step, settings(Mode::kCcd, Accuracy::kCertified));
  const Frame frame(case_of(step.scene, step.x, step.p), Mode::kDcd, Scalar::kF64, false);
  FrameInput input = frame.input();
  input.limits = true;
  EXPECT_EQ("limits", refused_field([&] { detector->detect(input); }));
  input.advance = true;
  EXPECT_EQ("", refused_field([&] { detector->detect(input); }));
}

}  // namespace
}  // namespace collided::test
