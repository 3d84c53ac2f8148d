// Frames that go by lists of neighbours answer with the bytes of frames that search, whatever the stream of frames
// does: small and large motion, other levels, modes and reports, frames that are refused, edits.

#include <cstdlib>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/scene/living_scene.hpp"
#include "tests/gpu/scene/sheets.hpp"
#include "tests/gpu/step/random_stream.hpp"
#include "tests/support/adversarial.hpp"
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

using Stream = RandomStream;

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

constexpr uint32_t kSide = RandomStream::kSide;

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

// Widened by a few frames' motion everything meets everything: a list would take a hundred searches to make.
TEST_F(ReusedLists, AreGivenUpWhereTheyTakeTooLongToMake) {
  const Case c = soup(7, 6000, 3, 0.3, 0.05);
  SceneSpec spec = spec_for(c, settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32));
  spec.threads = 1;
  const auto listing = Detector::create(spec);
  spec.reuse = Reuse::kOff;
  const auto searching = Detector::create(spec);
  const Frame frame(c, Mode::kCcd, Scalar::kF32);
  const FrameResult expected = searching->detect(frame.input());
  FrameResult last;
  for (int i = 0; i < 40; ++i) {
    last = listing->detect(frame.input());
    expect_same_answer(expected, last);
    EXPECT_TRUE(kBackend != Backend::kCpu || last.reuse.use != ListUse::kMade) << i;
  }
  EXPECT_TRUE(kBackend != Backend::kCpu || last.reuse.reason == ReuseReason::kSlower);
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
