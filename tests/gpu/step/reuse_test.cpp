// Frames that go by lists of neighbours answer with the bytes of frames that search, whatever the stream of frames
// does: small and large motion, other levels, modes and reports, frames that are refused, edits.

#include <cstdlib>
#include <limits>
#include <numbers>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/gpu/scene/living_scene.hpp"
#include "tests/gpu/scene/sheets.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

/// Streams of a test: COLLIDED_REUSE_STREAMS, or enough to see each kind of frame many times.
uint32_t stream_count() {
  const char* wanted = std::getenv("COLLIDED_REUSE_STREAMS");
  return wanted != nullptr ? static_cast<uint32_t>(std::atoi(wanted)) : 40;
}

void expect_same_answer(const FrameResult& expected, const FrameResult& got) {
  EXPECT_TRUE(same_contacts(expected, got)) << count_contacts(expected) << " against " << count_contacts(got);
  EXPECT_TRUE(same_bytes(expected.triangle_triangle, got.triangle_triangle));
  EXPECT_EQ(expected.earliest_toi, got.earliest_toi);
  EXPECT_EQ(expected.any_contact, got.any_contact);
  EXPECT_EQ(expected.input_resolution, got.input_resolution);
  EXPECT_EQ(expected.advanced, got.advanced);
}

/// Two scenes of one spec, one of which makes lists wherever it can.
struct Both {
  explicit Both(SceneSpec spec) {
    spec.reuse = Reuse::kOff;
    searching = Detector::create(spec);
    spec.reuse = Reuse::kOn;
    listing = Detector::create(spec);
  }
  /// The same frame to both; whether it counts.
  bool detect(const FrameInput& input) {
    std::string refusals[2];
    FrameResult expected = attempt(*searching, input, refusals[0]), got = attempt(*listing, input, refusals[1]);
    EXPECT_EQ(refusals[0], refusals[1]);
    if (!refusals[0].empty()) return false;
    expect_same_answer(expected, got);
    EXPECT_EQ(expected.reuse.use, ListUse::kNone);
    ++uses[static_cast<int>(got.reuse.use)];
    return true;
  }

  std::unique_ptr<Detector> searching, listing;
  uint64_t uses[3] = {0, 0, 0};  ///< of frames by ListUse

 private:
  static FrameResult attempt(Detector& detector, const FrameInput& input, std::string& refusal) {
    try {
      return detector.detect(input);
    } catch (const InvalidInput& e) {
      refusal = e.what();
      return {};
    }
  }
};

constexpr uint32_t kSide = 5;

/// Two sheets, one with a loose edge and a particle, over a static one, beside a rigid one.
class Stream {
 public:
  explicit Stream(uint32_t seed) : random_(seed) {
    constexpr Mode kModes[] = {Mode::kCcd, Mode::kDcd, Mode::kBoth};
    spec_ = settings(kModes[seed % 3], Accuracy::kCertified, seed / 3 % 2 == 0 ? Scalar::kF32 : Scalar::kF64,
                     seed % 4 == 0 && seed % 3 == 0 ? 0 : 0.05);
    spec_.threads = 1;
    if (spec_.mode != Mode::kDcd) spec_.min_separation = 0.01;
    spec_.fields = {ContactField::kElements, ContactField::kToi, ContactField::kDistance, ContactField::kFlags};
    for (int m = 0; m < 4; ++m) places_.push_back(shaken(flat_grid(kSide, 1), random(1u << 30), 0.2));
    for (int m = 0; m < 4; ++m)
      for (Vec3d& p : places_[static_cast<size_t>(m)]) p[0] += 0.3 * m, p[2] += 0.3 * m;
    spec_.meshes.assign(4, {kSide * kSide, grid_triangles(kSide)});
    spec_.meshes[0].motion = MeshMotion::kStatic;
    add_fringe(spec_.meshes[1], places_[1]);
    spec_.meshes[2].excluded_rings = random(2);
    spec_.meshes[2].excludes_rest_pairs = seed % 5 == 0;
    spec_.rest_distance = seed % 5 == 0 ? 0.3 : 0;
    spec_.meshes[3].motion = MeshMotion::kRigid;
  }

  const SceneSpec& spec() const { return spec_; }
  FrameInput first() {
    updates_.clear();
    for (uint32_t m = 0; m < 4; ++m) updates_.push_back({.mesh = m, .end = pack(places_[m], spec_.scalar)});
    return frame_of(updates_);
  }
  FrameInput next() {
    updates_.clear();
    const double by = random(8) == 0 ? 0.6 : random(8) == 0 ? 0 : 0.004;
    for (const uint32_t m : {1u, 2u}) move(m, by);
    if (random(2) == 0) turn(by);
    FrameInput input = frame_of(updates_);
    choose_options(input);
    if (random(10) == 0) edit(input);
    return input;
  }
  uint32_t random(uint32_t end) { return std::uniform_int_distribution<uint32_t>(0, end - 1)(random_); }

 private:
  static void add_fringe(MeshSpec& sheet, Positions& places) {
    sheet.edges = {{0, sheet.vertex_count}};
    sheet.points = {sheet.vertex_count + 1};
    places.push_back({places[0][0] + 0.5, places[0][1] + 0.75, places[0][2] + 0.25});
    places.push_back({places[0][0] + 1.5, places[0][1] + 0.5, places[0][2] + 0.5});
    sheet.vertex_count += 2;
  }
  bool is_continuous() const { return spec_.mode != Mode::kDcd; }

  /// All of its vertices, or a few; now and then with a number that no position may have.
  void move(uint32_t mesh, double by) {
    const Positions before = places_[mesh];
    Positions& places = places_[mesh];
    places = shaken(places, random(1u << 30), by);
    if (random(6) == 0)
      for (Vec3d& p : places) p[2] -= 2 * by;
    Positions end = places;
    if (random(24) == 0) end[random(kSide)][1] = std::numeric_limits<double>::quiet_NaN();
    if (random(3) > 0) {
      const bool has_start = is_continuous() && random(6) == 0;
      updates_.push_back(
          {.mesh = mesh,
           .start = has_start ? pack(shaken(before, random(1u << 30), by), spec_.scalar) : std::vector<std::byte>{},
           .end = pack(end, spec_.scalar)});
      return;
    }
    std::vector<uint32_t> indices;
    Positions some;
    for (uint32_t v = random(4); v < end.size(); v += 1 + random(5)) indices.push_back(v), some.push_back(end[v]);
    updates_.push_back(
        {.mesh = mesh, .is_sparse = true, .indices = bytes_of(indices), .end = pack(some, spec_.scalar)});
  }
  /// The rigid mesh, about an axis through its corner.
  void turn(double by) {
    angle_ += random(2) == 0 ? by : 0;
    const double c = std::cos(angle_), s = std::sin(angle_);
    shift_ += random(2) == 0 ? by : -by;
    const double rows[12] = {c, -s, 0, shift_, s, c, 0, 0, 0, 0, 1, shift_};
    const auto* bytes = reinterpret_cast<const std::byte*>(rows);
    updates_.push_back({.mesh = 3, .transform = {bytes, bytes + sizeof(rows)}});
  }
  void choose_options(FrameInput& input) {
    constexpr Accuracy kLevels[] = {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded, Accuracy::kExact};
    if (random(3) == 0) input.accuracy = kLevels[random(4)];
    if (spec_.mode == Mode::kBoth && random(2) == 0) input.mode = Mode::kDcd;
    const bool is_continuous = this->is_continuous() && input.mode != Mode::kDcd;
    const Accuracy level = input.accuracy.value_or(spec_.accuracy);
    if (random(6) == 0 && level > Accuracy::kCandidates) input.report = Report::kAnyHit;
    if (random(6) == 0 && is_continuous && level >= Accuracy::kGuarded) input.report = Report::kEarliestOnly;
    input.trial = random(8) == 0;
    input.advance = is_continuous && level >= Accuracy::kCertified && random(6) == 0;
  }
  /// Meshes that may touch no more, or again; a triangle that is torn out.
  void edit(FrameInput& input) {
    SceneEdit edit;
    if (random(2) == 0) {
      (is_excluded_ ? edit.included : edit.excluded).push_back({1, 2});
    } else {
      MeshSpec torn = spec_.meshes[2];
      torn.triangles.resize(torn.triangles.size() - random(3));
      edit.meshes.push_back({2, torn});
    }
    if (!input.trial) is_excluded_ = is_excluded_ != (edit.meshes.empty());
    input.edit = std::make_shared<const SceneEdit>(edit);
  }

  std::mt19937 random_;
  SceneSpec spec_;
  std::vector<Positions> places_;
  std::vector<OwnedUpdate> updates_;
  double angle_ = 0, shift_ = 0;
  bool is_excluded_ = false;
};

/// A frame that is given up on its way.
void give_up(Detector& detector, FrameInput input, int asks) {
  input.trial = true;
  input.cancelled = [&] { return --asks < 0; };
  try {
    detector.detect(input);
  } catch (const Cancelled&) {
  } catch (const InvalidInput&) {
  }
}

using ReusedLists = OnBackend<>;

TEST_F(ReusedLists, GiveTheBytesOfASearch) {
  constexpr int kFrames = 24;
  uint64_t uses[3] = {0, 0, 0}, refused = 0;
  const uint32_t streams = stream_count();
  for (uint32_t seed = 0; seed < streams; ++seed) {
    Stream stream(seed);
    Both both(stream.spec());
    both.detect(stream.first());
    for (int frame = 0; frame < kFrames && !HasFailure(); ++frame) {
      SCOPED_TRACE("stream " + std::to_string(seed) + " frame " + std::to_string(frame));
      const FrameInput input = stream.next();
      if (stream.random(8) == 0) give_up(*both.listing, input, static_cast<int>(stream.random(12)));
      refused += !both.detect(input);
    }
    for (int use = 0; use < 3; ++use) uses[use] += both.uses[use];
    if (HasFailure()) return;
  }
  const uint64_t all = uint64_t{streams} * kFrames;
  EXPECT_GT(uses[static_cast<int>(ListUse::kReused)], all / 8);
  EXPECT_GT(uses[static_cast<int>(ListUse::kMade)], all / 8);
  EXPECT_GT(refused, all / 64);
  RecordProperty("searched", static_cast<int>(uses[0]));
  RecordProperty("made", static_cast<int>(uses[1]));
  RecordProperty("reused", static_cast<int>(uses[2]));
}

TEST_F(ReusedLists, FollowEdits) {
  for (const Mode mode : {Mode::kCcd, Mode::kDcd}) {
    LivingScene scene(mode, Scalar::kF32, 7);
    Both both(scene.spec());
    both.detect(scene.first_frame().input());
    for (int i = 0; i < 40; ++i) {
      SCOPED_TRACE(i);
      const OwnedFrame frame = i % 4 == 3 ? scene.next_edit() : scene.next_frame();
      ASSERT_TRUE(both.detect(frame.input()));
      scene.applied(frame);
      ASSERT_FALSE(HasFailure());
    }
    EXPECT_GT(both.uses[static_cast<int>(ListUse::kMade)], 10u);
  }
}

/// Two sheets a little apart, the upper one `lower` down; in CCD from where the last frame left it.
Case sheets(double lower) {
  Case c;
  add_mesh(c, grid_triangles(kSide), flat_grid(kSide, 1), {}, true);
  Positions upper = flat_grid(kSide, 1);
  for (Vec3d& p : upper) p[0] += 0.3, p[1] += 0.2, p[2] = 1 - lower;
  add_mesh(c, grid_triangles(kSide), upper, upper);
  return c;
}

class FallingSheet : public OnBackend<::testing::TestWithParam<Mode>> {};

// Each frame alone is within the margin; together they are not.
TEST_P(FallingSheet, IsNotMissedHoweverSlowlyItComes) {
  SceneSpec spec = spec_for(sheets(0), settings(GetParam(), Accuracy::kCertified, Scalar::kF32, 0.01));
  Both both(spec);
  uint64_t contacts = 0;
  for (int i = 0; i <= 120; ++i) {
    const Frame frame(sheets(0.01 * i), GetParam(), Scalar::kF32, i == 0);
    FrameInput input = frame.input();
    if (GetParam() == Mode::kCcd && i > 0)
      for (MeshPositions& update : input.updates) update.start = {};
    const FrameResult found = both.listing->detect(input);
    expect_same_answer(both.searching->detect(input), found);
    contacts += count_contacts(found);
    both.uses[static_cast<int>(found.reuse.use)]++;
  }
  EXPECT_GT(contacts, 0u);
  EXPECT_GT(both.uses[static_cast<int>(ListUse::kReused)], 80u);
}
INSTANTIATE_TEST_SUITE_P(Modes, FallingSheet, ::testing::Values(Mode::kCcd, Mode::kDcd));

// After many frames that hardly move, one that brings the upper sheet through the lower one.
TEST_P(FallingSheet, IsNotMissedWhenItJumps) {
  SceneSpec spec = spec_for(sheets(0), settings(GetParam(), Accuracy::kCertified, Scalar::kF32, 0.01));
  Both both(spec);
  FrameResult last;
  std::vector<ListUse> uses;
  std::vector<size_t> contacts;
  for (const double lower : {0.0, 0.001, 0.002, 0.003, 0.004, 0.995, 0.996, 0.2, 0.2}) {
    const Frame frame(sheets(lower), GetParam(), Scalar::kF32, lower == 0);
    FrameInput input = frame.input();
    if (lower > 0)
      for (MeshPositions& update : input.updates) update.start = {};
    last = both.listing->detect(input);
    expect_same_answer(both.searching->detect(input), last);
    uses.push_back(last.reuse.use);
    contacts.push_back(count_contacts(last));
  }
  EXPECT_EQ(uses[4], ListUse::kReused);
  EXPECT_EQ(uses[5], ListUse::kNone);
  EXPECT_EQ(contacts[4], 0u);
  EXPECT_GT(contacts[5], 0u);
}

// A larger thickness reaches farther than the lists of a smaller one.
TEST_F(ReusedLists, AreMadeAnewForALargerThickness) {
  SceneSpec spec = spec_for(sheets(0.9), settings(Mode::kBoth, Accuracy::kCertified, Scalar::kF64, 0.2));
  Both both(spec);
  const auto run = [&](Mode mode, bool is_first) {
    const Frame frame(sheets(0.9), Mode::kDcd, Scalar::kF64, is_first);
    FrameInput input = frame.input();
    input.mode = mode;
    const FrameResult found = both.listing->detect(input);
    expect_same_answer(both.searching->detect(input), found);
    return found;
  };
  run(Mode::kCcd, true);
  run(Mode::kCcd, false);
  const FrameResult thick = run(Mode::kDcd, false);
  EXPECT_EQ(thick.reuse.use, ListUse::kMade);
  EXPECT_GT(count_contacts(thick), 0u);
  EXPECT_EQ(run(Mode::kCcd, false).reuse.use, ListUse::kReused);  // what holds more serves for less
}

TEST_F(ReusedLists, KeepToTheMemoryBudget) {
  const Case c = sheets(0.9);
  SceneSpec spec = spec_for(c, settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32));
  const auto bytes = [](const Detector& detector) {
    uint64_t sum = 0;
    for (const MemoryPart& part : detector.memory()) sum += part.bytes;
    return sum;
  };
  spec.reuse = Reuse::kOff;
  const auto without = Detector::create(spec);
  const Frame first(c, Mode::kCcd, Scalar::kF32);
  const FrameResult expected = without->detect(first.input());
  spec.memory_budget = bytes(*without) + 256;
  spec.reuse = Reuse::kOn;
  const auto tight = Detector::create(spec);
  const FrameResult found = tight->detect(first.input());
  EXPECT_EQ(found.reuse.use, ListUse::kNone);
  expect_same_answer(expected, found);
  for (const MemoryPart& part : tight->memory()) EXPECT_NE(part.part, "neighbours");
}

// A question that ends early, or asks for triangles, needs a search.
TEST_F(ReusedLists, AreNotForEveryQuestion) {
  const Case c = sheets(0.99);
  SceneSpec spec = spec_for(c, settings(Mode::kDcd, Accuracy::kCertified, Scalar::kF32, 0.1));
  spec.reuse = Reuse::kOn;
  const auto detector = Detector::create(spec);
  const Frame frame(c, Mode::kDcd, Scalar::kF32);
  FrameInput input = frame.input();
  input.report = Report::kAnyHit;
  const FrameResult any = detector->detect(input);
  EXPECT_EQ(any.reuse.use, ListUse::kNone);
  EXPECT_EQ(any.reuse.reason, ReuseReason::kUnsuited);
  EXPECT_TRUE(any.any_contact);
  spec.kinds.triangle_triangle = true;
  EXPECT_EQ(run_case(c, spec).reuse.reason, ReuseReason::kUnsuited);
}

// Who names an engine sees it work in each frame.
TEST_F(ReusedLists, AreNotMadeBesideANamedEngine) {
  const Case c = sheets(0.99);
  SceneSpec spec = spec_for(c, settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32));
  spec.engine = Engine::kLbvh;
  const auto detector = Detector::create(spec);
  const Frame first(c, Mode::kCcd, Scalar::kF32), next(c, Mode::kCcd, Scalar::kF32, false);
  detector->detect(first.input());
  for (int i = 0; i < 40; ++i) {
    const ReuseFacts facts = detector->detect(next.input()).reuse;
    ASSERT_EQ(facts.use, ListUse::kNone);
    ASSERT_EQ(facts.reason, ReuseReason::kAsked);
  }
}

}  // namespace
}  // namespace collided::test
