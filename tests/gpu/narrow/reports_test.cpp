// EARLIEST_ONLY and ANY_HIT against what ALL says.

#include <algorithm>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/scene/sheets.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

constexpr Accuracy kLevels[] = {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact};

SceneSpec ccd(Accuracy accuracy, double delta = 0) {
  SceneSpec spec = settings(Mode::kCcd, accuracy);
  spec.delta = delta;
  spec.fields = spec.fields.with(ContactField::kWeights);
  return spec;
}

FrameResult run_report(const Case& c, SceneSpec spec, Report report) {
  spec.report = report;
  return run_case(c, spec);
}

// Entry i alone.
ContactSet only(const ContactSet& set, size_t i) {
  ContactSet one;
  for_each_field(
      [&](ContactField, auto& column, const auto& all) {
        if (!all.empty()) column = {all[i]};
      },
      one, set);
  return one;
}

// The contact that EARLIEST_ONLY has to answer with: vertex-triangle first, then the lowest ids.
FrameResult earliest_of(const FrameResult& all) {
  FrameResult expected;
  for (auto kind : {&FrameResult::vertex_triangle, &FrameResult::edge_edge})
    for (size_t i = 0; i < (all.*kind).size(); ++i) {
      const bool has_one = expected.vertex_triangle.size() + expected.edge_edge.size() > 0;
      const double toi = (all.*kind).toi[i];
      if (has_one && toi >= expected.earliest_toi) continue;
      expected.earliest_toi = toi;
      expected.vertex_triangle = expected.edge_edge = {};
      expected.*kind = only(all.*kind, i);
    }
  return expected;
}

void expect_earliest_is_of_all(const Case& c, const SceneSpec& spec) {
  const FrameResult all = run_report(c, spec, Report::kAll), expected = earliest_of(all);
  for (int threads : {1, 2, 2}) {
    SceneSpec with_threads = spec;
    with_threads.threads = threads;
    const FrameResult earliest = run_report(c, with_threads, Report::kEarliestOnly);
    EXPECT_EQ(expected.earliest_toi, earliest.earliest_toi);
    EXPECT_TRUE(same_contacts(expected, earliest))
        << earliest.vertex_triangle.size() << " + " << earliest.edge_edge.size() << " contacts";
    EXPECT_EQ(all.any_contact, earliest.any_contact);
    EXPECT_EQ(all.earliest_toi, earliest.earliest_toi);
  }
}

void expect_any_is_of_all(const Case& c, const SceneSpec& spec) {
  const FrameResult all = run_report(c, spec, Report::kAll), any = run_report(c, spec, Report::kAnyHit);
  EXPECT_EQ(all.any_contact, any.any_contact);
  EXPECT_EQ(any.vertex_triangle.size() + any.edge_edge.size() + any.triangle_triangle.size(), 0u);
  EXPECT_EQ(any.earliest_toi, 1);
}

class Reports : public OnBackend<::testing::TestWithParam<Accuracy>> {};

TEST_P(Reports, OfSoups) {
  for (uint32_t seed : {120u, 121u, 122u})
    for (double delta : {0.0, 1e-3, 0.05}) {
      SCOPED_TRACE(std::to_string(seed) + ", delta " + std::to_string(delta));
      const Case c = soup(seed, 200, 1, 0.1, 0.1);
      expect_earliest_is_of_all(c, ccd(GetParam(), delta));
      expect_any_is_of_all(c, ccd(GetParam(), delta));
    }
}

// Many contacts at the same times, many at t = 0.
TEST_P(Reports, OfLattices) {
  for (uint32_t seed : {123u, 124u}) {
    Case c = lattice(seed, 40, 8);
    expect_earliest_is_of_all(c, ccd(GetParam()));
    expect_any_is_of_all(c, ccd(GetParam()));
    SceneSpec thick = ccd(GetParam());
    thick.thickness = 0.5;
    expect_earliest_is_of_all(c, thick);
    for (bool vertex_triangle : {false, true}) {
      SceneSpec one_kind = ccd(GetParam());
      (vertex_triangle ? one_kind.kinds.edge_edge : one_kind.kinds.vertex_triangle) = false;
      expect_earliest_is_of_all(c, one_kind);
    }
  }
}

const Positions kFloor{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

// A narrow triangle, tip down, at (x, y) over the floor; the other corners are far above and to the side.
void add_spike(Case& c, double x, double y, double from, double to) {
  const auto spike = [&](double z) { return Positions{{x, y, z}, {x + 0.05, y, z + 40}, {x, y + 0.05, z + 40}}; };
  add_mesh(c, {{0, 1, 2}}, spike(from), spike(to));
}

// A blade along x that comes down on one along y: edges alone meet, at a quarter of the way from 1 to -3.
void add_blades(Case& c, double from, double to) {
  add_mesh(c, {{0, 1, 2}}, {{10, -1, 0}, {10, 3, 0}, {10, 0, -5}});
  const auto blade = [](double z) { return Positions{{9, 0, z}, {11, 0, z}, {10, 0, z + 4}}; };
  add_mesh(c, {{0, 1, 2}}, blade(from), blade(to));
}

Case floor_and_spike(double from, double to) {
  Case c;
  add_mesh(c, {{0, 1, 2}}, kFloor);
  add_spike(c, 0.25, 0.25, from, to);
  return c;
}

TEST_P(Reports, NoContact) {
  Case c = floor_and_spike(1, 0.5);
  add_blades(c, 1, 0.5);
  expect_earliest_is_of_all(c, ccd(GetParam()));
  expect_any_is_of_all(c, ccd(GetParam()));
  const FrameResult earliest = run_report(c, ccd(GetParam()), Report::kEarliestOnly);
  EXPECT_EQ(earliest.earliest_toi, 1);
  EXPECT_FALSE(earliest.any_contact);
  EXPECT_EQ(earliest.vertex_triangle.size() + earliest.edge_edge.size(), 0u);
}

TEST_P(Reports, OfTheSecondKindAlone) {
  Case c = floor_and_spike(1, 0.5);
  add_blades(c, 1, -3);
  const FrameResult all = run_case(c, ccd(GetParam()));
  EXPECT_EQ(all.vertex_triangle.size(), 0u);
  EXPECT_EQ(all.edge_edge.size(), 1u);
  expect_earliest_is_of_all(c, ccd(GetParam()));
  EXPECT_NEAR(run_report(c, ccd(GetParam()), Report::kEarliestOnly).earliest_toi, 0.25, 1e-5);
  EXPECT_TRUE(run_report(c, ccd(GetParam()), Report::kAnyHit).any_contact);
}

TEST_P(Reports, TheSecondKindIsEarlier) {
  Case c = floor_and_spike(1, -1);
  add_blades(c, 1, -3);
  expect_earliest_is_of_all(c, ccd(GetParam()));
  EXPECT_EQ(run_report(c, ccd(GetParam()), Report::kEarliestOnly).edge_edge.size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(Levels, Reports, ::testing::ValuesIn(kLevels),
                         [](const auto& info) { return level_name(info.param); });

using ReportCases = OnBackend<>;

constexpr double kDelta = 1e-3;

// The tip starts above and outside the floor's longest edge, at a distance well below kDelta, and goes down past it.
void add_near_miss(Case& c) { add_spike(c, 0.5 + kDelta / 10, 0.5 + kDelta / 10, kDelta / 10, -0.5); }

// Near contacts are answers until EXACT, where they are not to hide the later true one.
TEST_F(ReportCases, ANearMissBeforeTheContact) {
  Case c;
  add_mesh(c, {{0, 1, 2}}, kFloor);
  add_near_miss(c);
  add_spike(c, 0.25, 0.25, 3, -1);
  for (Accuracy accuracy : kLevels) {
    const SceneSpec spec = ccd(accuracy, kDelta);
    expect_earliest_is_of_all(c, spec);
    const FrameResult earliest = run_report(c, spec, Report::kEarliestOnly);
    EXPECT_NEAR(earliest.earliest_toi, accuracy == Accuracy::kExact ? 0.75 : 0, kDelta);
    EXPECT_TRUE(run_report(c, spec, Report::kAnyHit).any_contact);
  }
}

TEST_F(ReportCases, NearMissesAlone) {
  Case c;
  add_mesh(c, {{0, 1, 2}}, kFloor);
  add_near_miss(c);
  for (Accuracy accuracy : kLevels) {
    const SceneSpec spec = ccd(accuracy, kDelta);
    expect_earliest_is_of_all(c, spec);
    EXPECT_EQ(run_report(c, spec, Report::kAnyHit).any_contact, accuracy != Accuracy::kExact);
    EXPECT_EQ(run_report(c, spec, Report::kEarliestOnly).any_contact, accuracy != Accuracy::kExact);
  }
}

// A slow contact whose time is reported as 0, which EXACT finds to be later than a quick one's.
TEST_F(ReportCases, ATimeThatExactPutsOff) {
  Case c;
  add_mesh(c, {{0, 1, 2}}, kFloor);
  add_spike(c, 0.25, 0.25, kDelta / 20, -1);
  add_spike(c, 0.25, 0.5, 1.5 * kDelta, -100);
  for (Accuracy accuracy : kLevels) expect_earliest_is_of_all(c, ccd(accuracy, kDelta));
  const FrameResult exact = run_report(c, ccd(Accuracy::kExact, kDelta), Report::kEarliestOnly);
  EXPECT_EQ(exact.vertex_triangle.elements, (std::vector<std::array<uint32_t, 2>>{{6, 0}}));
}

// Of contacts that delta makes early, the order in which they are looked at must not choose.
TEST_F(ReportCases, NearAtTheStartWhateverComesFirst) {
  for (bool slow_first : {false, true}) {
    Case c;
    add_mesh(c, {{0, 1, 2}}, kFloor);
    if (slow_first) add_spike(c, 0.25, 0.25, kDelta / 2, -kDelta);
    add_spike(c, 0.25, 0.5, 3 * kDelta, -20 * kDelta);
    if (!slow_first) add_spike(c, 0.25, 0.25, kDelta / 2, -kDelta);
    for (Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified}) {
      expect_earliest_is_of_all(c, ccd(accuracy, kDelta));
      EXPECT_EQ(run_report(c, ccd(accuracy, kDelta), Report::kEarliestOnly).earliest_toi, 0);
    }
  }
}

TEST_F(ReportCases, AnyHitOfEveryModeAndKind) {
  Case pierced;  // triangles meet, their features do not
  add_mesh(pierced, {{0, 1, 2}}, {{-4, -4, 0}, {4, -4, 0}, {0, 4, 0}});
  add_mesh(pierced, {{0, 1, 2}}, {{0, 0, 2}, {1, 0, -2}, {-1, 0, -2}});
  Case blades = floor_and_spike(1, 1);
  add_blades(blades, 0.005, 0.005);
  const Case nothing = floor_and_spike(1, 1);
  for (Accuracy accuracy : {Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact})
    for (const Case* c : std::initializer_list<const Case*>{&pierced, &blades, &nothing}) {
      SceneSpec spec = settings(Mode::kDcd, accuracy, Scalar::kF64, 0.01);
      expect_any_is_of_all(*c, spec);
      EXPECT_EQ(run_report(*c, spec, Report::kAnyHit).any_contact, c == &blades);
      spec.kinds.triangle_triangle = true;
      expect_any_is_of_all(*c, spec);
      EXPECT_EQ(run_report(*c, spec, Report::kAnyHit).any_contact, c != &nothing);
    }
}

TEST_F(ReportCases, AnyHitAtFast) {
  expect_any_is_of_all(floor_and_spike(1, -1), ccd(Accuracy::kFast));
  expect_any_is_of_all(floor_and_spike(1, 0.5), ccd(Accuracy::kFast));
  Case c = floor_and_spike(1, 0.5);
  add_blades(c, 1, -3);
  expect_any_is_of_all(c, ccd(Accuracy::kFast));
}

TEST_F(ReportCases, AnyHitOfACrowd) {
  for (Accuracy accuracy : kLevels) {
    const Case c = soup(125, 300, 0.3, 0.2, 0.1);
    expect_any_is_of_all(c, ccd(accuracy));
    EXPECT_TRUE(run_report(c, ccd(accuracy), Report::kAnyHit).any_contact);
  }
}

// Every pair of these triangles is a candidate many times, and the first few decide.
TEST_F(ReportCases, AnyHitLeavesMostCandidatesUnmade) {
  if (kBackend != Backend::kCpu) GTEST_SKIP() << "a GPU works on all pairs of a small scene at once";
  const Case c = soup(70, 450, 0.01, 0.5, 0.3);
  const auto candidates = [&](Report report) {
    const FrameResult result = run_report(c, ccd(Accuracy::kGuarded), report);
    EXPECT_TRUE(result.any_contact);
    return result.counts.candidates.vertex_triangle + result.counts.candidates.edge_edge;
  };
  EXPECT_LT(10 * candidates(Report::kAnyHit), candidates(Report::kAll));
}

/// Two slanted sheets, close to each other and apart. The boxes of their features overlap many times. The last vertex
/// of one is drawn down by `way`: 1.8 brings it onto the other.
Case slanted_sheets(double way) {
  constexpr uint32_t kSide = 40;
  const auto sheet = [](double gap) {
    return grid(kSide, [&](double i, double j) { return Vec3d{i, j, 3 * i + 3 * j + gap}; });
  };
  Case c;
  add_mesh(c, grid_triangles(kSide), sheet(0));
  Positions end = sheet(0.3);
  if (way > 0) end.back() = {end.back()[0] - 0.25, end.back()[1] - 0.25, end.back()[2] - way};
  add_mesh(c, grid_triangles(kSide), sheet(0.3), end);
  for (MeshSpec& mesh : c.meshes) mesh.self_contacts = false;
  return c;
}

// Frame by frame, with and without: what the last frame found is no answer.
TEST_F(ReportCases, AnyHitFindsTheOneContactAmongManyCandidates) {
  struct Kind {
    Mode mode;
    PerKind<bool> kinds;
    double way;
  };
  const PerKind<bool> features{.vertex_triangle = true, .edge_edge = true}, triangles{.triangle_triangle = true};
  for (const Kind& kind : {Kind{Mode::kCcd, features, 3}, {Mode::kDcd, features, 1.8}, {Mode::kDcd, triangles, 3}}) {
    SceneSpec spec = settings(kind.mode, Accuracy::kFast, Scalar::kF64, kind.mode == Mode::kDcd ? 0.01 : 0);
    spec.kinds = kind.kinds;
    const FrameResult all = run_report(slanted_sheets(kind.way), spec, Report::kAll);
    EXPECT_TRUE(all.any_contact);
    ASSERT_GT(kind.kinds.edge_edge ? all.counts.candidates.edge_edge : all.counts.pairs, 4 * 4096u);
    EXPECT_FALSE(run_report(slanted_sheets(0), spec, Report::kAll).any_contact);
    spec.report = Report::kAnyHit;
    const auto scene = Detector::create(spec_for(slanted_sheets(0), spec));
    for (const bool hit : {false, true, true, false, true, false, false}) {
      const Case c = slanted_sheets(hit ? kind.way : 0);
      EXPECT_EQ(scene->detect(Frame(c, kind.mode, Scalar::kF64).input()).any_contact, hit);
    }
  }
}

}  // namespace
}  // namespace collided::test
