// A step runs as a whole, without asking the host: what a warm frame costs, and what becomes of a frame whose lists are
// too short.

#include <algorithm>
#include <chrono>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

/// A detector whose every frame is held against what a step promises of itself.
class Player {
 public:
  Player(const Case& c, const SceneSpec& settings) : spec_(spec_for(c, settings)), detector_(Detector::create(spec_)) {}

  FrameResult play(const Case& c, std::optional<Accuracy> accuracy = {}, std::optional<Report> report = {}) {
    const Frame frame(c, spec_.mode, spec_.scalar, is_first_);
    FrameInput input = frame.input();
    input.accuracy = accuracy;
    input.report = report;
    const auto start = std::chrono::steady_clock::now();
    FrameResult result = detector_->detect(input);
    const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - start;
    // Steps that memory is allocated for are not recorded.
    if (kBackend == Backend::kCpu)
      EXPECT_EQ(result.graph_launches, 0u);
    else if (result.allocations == 0)
      EXPECT_EQ(result.graph_launches, 1 + result.replays);
    else
      EXPECT_LE(result.graph_launches, 1 + result.replays);
    EXPECT_GT(result.step_milliseconds, 0);
    EXPECT_LE(result.step_milliseconds, wall.count());
    EXPECT_LE(result.replays, kMaxReplays) << "lists grow to what was asked for, not bit by bit";
    is_first_ = false;
    return result;
  }

 private:
  // Each list's need is known once those before it had room; bricks are found round by round.
  static constexpr uint32_t kMaxReplays = 8;
  SceneSpec spec_;
  std::unique_ptr<Detector> detector_;
  bool is_first_ = true;
};

void expect_same_answer(const FrameResult& expected, const FrameResult& got) {
  EXPECT_TRUE(same_contacts(expected, got));
  EXPECT_TRUE(same_bytes(expected.triangle_triangle, got.triangle_triangle));
  EXPECT_EQ(expected.earliest_toi, got.earliest_toi);
  EXPECT_EQ(expected.any_contact, got.any_contact);
}

uint64_t contacts_of(const FrameResult& result) {
  return result.vertex_triangle.size() + result.edge_edge.size() + result.triangle_triangle.size();
}

void expect_warm(const FrameResult& frame) {
  EXPECT_EQ(frame.allocations, 0u);
  EXPECT_EQ(frame.replays, 0u);
}

struct Setting {
  const char* name;
  Mode mode;
  Accuracy accuracy;
  Report report = Report::kAll;
  bool triangles = false;
};
void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }

SceneSpec spec_of(const Setting& setting) {
  SceneSpec spec = settings(setting.mode, setting.accuracy, Scalar::kF32, setting.mode == Mode::kDcd ? 0x1p-6 : 0);
  spec.report = setting.report;
  spec.kinds.triangle_triangle = setting.triangles;
  spec.fields = spec.fields.with(ContactField::kWeights);
  return spec;
}

// All lists that a step has come up in one of them.
std::vector<Setting> all_settings() {
  return {{"Candidates", Mode::kCcd, Accuracy::kCandidates, Report::kAll, true},
          {"Fast", Mode::kCcd, Accuracy::kFast},
          {"Guarded", Mode::kCcd, Accuracy::kGuarded},
          {"Certified", Mode::kCcd, Accuracy::kCertified},
          {"Exact", Mode::kCcd, Accuracy::kExact},
          {"Earliest", Mode::kCcd, Accuracy::kCertified, Report::kEarliestOnly},
          {"AnyHit", Mode::kCcd, Accuracy::kGuarded, Report::kAnyHit},
          {"Discrete", Mode::kDcd, Accuracy::kFast, Report::kAll, true},
          {"DiscreteExact", Mode::kDcd, Accuracy::kExact, Report::kAll, true}};
}

class Step : public OnBackend<::testing::TestWithParam<Setting>> {};

// The same motion again and again: the needs of each cycle are those of the one before.
TEST_P(Step, AllocatesNothingOnceItIsWarm) {
  const auto scene = scenes::make_scene("reef_knot", 0.3);
  constexpr int kCycle = 10;
  std::vector<Case> cycle;
  for (int i = 0; i < kCycle; ++i)
    cycle.push_back(rounded(case_of(*scene, 0.4 + 0.01 * i, 0.41 + 0.01 * i), Scalar::kF32));
  SceneSpec spec = spec_of(GetParam());
  spec.reuse = Reuse::kOff;       // what is near is not the same from cycle to cycle
  spec.engine = Engine::kOctree;  // AUTO tries another engine at times, whose first lists are new
  Player player(cycle[0], spec);
  for (int frame = 0; frame < 5 * kCycle; ++frame) {
    SCOPED_TRACE(frame);
    const FrameResult result = player.play(cycle[frame % kCycle]);
    if (frame >= 2 * kCycle) expect_warm(result);
  }
}

/// A small scene many times over, in the same place, each copy blind to the others.
constexpr uint32_t kCopies = 32;
Case copies_of(const Case& one) {
  Case c;
  for (uint32_t copy = 0; copy < kCopies; ++copy) {
    add_mesh(c, one.meshes[0].triangles, one.start[0], one.end[0]);
    c.meshes.back().groups = c.meshes.back().collide_mask = 1u << copy;
  }
  return c;
}

/// The contacts of all copies; `first` and `second`: how many ids of each kind a copy has.
ContactSet copies_of(const ContactSet& one, size_t first, size_t second) {
  std::vector<std::array<uint32_t, 2>> elements;
  for (uint32_t copy = 0; copy < kCopies; ++copy)
    for (const auto& [a, b] : one.elements)
      elements.push_back({a + copy * static_cast<uint32_t>(first), b + copy * static_cast<uint32_t>(second)});
  const auto repeated = [](const auto& column) {
    std::vector<std::decay_t<decltype(column[0])>> all;
    for (uint32_t copy = 0; copy < kCopies; ++copy) all.insert(all.end(), column.begin(), column.end());
    return all;
  };
  ContactSet all;
  for_each_field([&](ContactField, auto& column, const auto& of_one) { column = repeated(of_one); }, all, one);
  all.elements = elements;
  return all;
}

// Where everything stands still, many contacts are the earliest: all are at t = 0.
Case small_case(Report report) {
  if (report != Report::kEarliestOnly) return lattice(210, 40, 12);
  Case c = lattice(211, 70, 12);
  c.end = c.start;
  return c;
}

FrameResult expected_of_copies(const FrameResult& one, const Case& c, Report report) {
  if (report != Report::kAll) return one;  // the first of the earliest, or none
  const Features features = features_of(c);
  const size_t vertices = c.start[0].size(), triangles = features.triangles.size(), edges = features.edges.size();
  FrameResult all;
  all.vertex_triangle = copies_of(one.vertex_triangle, vertices, triangles);
  all.edge_edge = copies_of(one.edge_edge, edges, edges);
  all.triangle_triangle = copies_of(one.triangle_triangle, triangles, triangles);
  all.earliest_toi = one.earliest_toi;
  all.any_contact = one.any_contact;
  return all;
}

// Nothing of the small scene has to grow, so that what it finds does not depend on what is put to the test.
TEST_P(Step, WhoseListsAreTooShortRunsAgainAndLosesNothing) {
  const Case one = small_case(GetParam().report);
  const SceneSpec spec = spec_of(GetParam());
  const FrameResult small = Player(one, spec).play(one);
  ASSERT_EQ(small.replays, 0u) << "the small scene is too large";

  const Case many = copies_of(one);
  Player player(many, spec);
  const FrameResult grown = player.play(many), warm = player.play(many);
  const FrameResult expected = expected_of_copies(small, one, GetParam().report);
  expect_same_answer(expected, grown);
  expect_same_answer(expected, warm);
  expect_warm(warm);
  if (GetParam().report == Report::kAnyHit) return;  // the search ends with the first contact
  EXPECT_GT(grown.replays, 0u);
  if (GetParam().report == Report::kEarliestOnly) return;
  EXPECT_GT(contacts_of(grown), 1024u) << "fits into the first lists";
}

INSTANTIATE_TEST_SUITE_P(Settings, Step, ::testing::ValuesIn(all_settings()),
                         [](const auto& info) { return std::string(info.param.name); });

using Steps = OnBackend<>;

TEST_F(Steps, OfAlternatingLevelsAndReportsAllocateNothingOnceEachWasSeen) {
  const Case c = rounded(soup(200, 400, 1, 0.2, 0.1), Scalar::kF32);
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCandidates, Scalar::kF32);
  spec.engine = Engine::kOctree;  // to compare engines takes memory now and then
  Player player(c, spec);
  const std::pair<Accuracy, Report> overrides[] = {
      {Accuracy::kCandidates, Report::kAll},     {Accuracy::kExact, Report::kAll},
      {Accuracy::kFast, Report::kAnyHit},        {Accuracy::kCertified, Report::kEarliestOnly},
      {Accuracy::kGuarded, Report::kAll},        {Accuracy::kFast, Report::kAll},
      {Accuracy::kExact, Report::kEarliestOnly}, {Accuracy::kCertified, Report::kAll}};
  for (int round = 0; round < 6; ++round)
    for (const auto& [accuracy, report] : overrides) {
      SCOPED_TRACE(testing::Message() << level_name(accuracy) << ", round " << round);
      const FrameResult result = player.play(c, accuracy, report);
      if (round >= 1) expect_warm(result);
    }
}

// The same triangles far apart and close together.
Case scattered() { return rounded(soup(201, 900, 20, 0.4, 0.1), Scalar::kF32); }
Case crowded() { return rounded(soup(201, 900, 1.5, 0.4, 0.1), Scalar::kF32); }

void expect_brute_force(const FrameResult& result, const Case& c) {
  const ExpectedPairs expected = brute_force(c, Mode::kCcd, Scalar::kF32, 0);
  EXPECT_EQ("", compare(result.vertex_triangle.elements, expected.vertex_triangle));
  EXPECT_EQ("", compare(result.edge_edge.elements, expected.edge_edge));
}

TEST_F(Steps, FirstFrameWithManyContactsRunsAgain) {
  const SceneSpec spec = settings(Mode::kCcd, Accuracy::kCandidates, Scalar::kF32);
  const FrameResult first = Player(crowded(), spec).play(crowded());
  EXPECT_GT(first.replays, 0u);
  expect_brute_force(first, crowded());

  Player other(crowded(), spec);
  for (const Case& before : {scattered(), crowded(), scattered()}) other.play(before);
  expect_same_answer(first, other.play(crowded()));
}

class SuddenCrowd : public OnBackend<::testing::TestWithParam<Accuracy>> {};

TEST_P(SuddenCrowd, LosesNothingAndLeavesRoomForTheNext) {
  SceneSpec spec = settings(Mode::kCcd, GetParam(), Scalar::kF32);
  spec.engine = Engine::kOctree;
  Player player(scattered(), spec);
  FrameResult few;
  // The octree's levels move from frame to frame; of those that the crowd may meet, these need the longest lists.
  for (int frame = 0; frame < 2; ++frame) few = player.play(scattered());
  EXPECT_EQ(few.replays, 0u);

  const FrameResult many = player.play(crowded());
  EXPECT_GT(many.replays, 0u);
  EXPECT_GT(contacts_of(many), 100 * contacts_of(few));
  EXPECT_GT(contacts_of(few), 0u);
  expect_same_answer(Player(crowded(), spec).play(crowded()), many);
  if (GetParam() == Accuracy::kCandidates) expect_brute_force(many, crowded());

  for (const bool crowd : {true, true, false, false, true, false}) {
    SCOPED_TRACE(crowd);
    const FrameResult next = player.play(crowd ? crowded() : scattered());
    expect_same_answer(crowd ? many : few, next);
    EXPECT_EQ(next.replays, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Levels, SuddenCrowd,
                         ::testing::Values(Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded,
                                           Accuracy::kCertified, Accuracy::kExact),
                         [](const auto& info) { return level_name(info.param); });

}  // namespace
}  // namespace collided::test
