// What one frame leaves behind for the next: positions, grown buffers, and nothing else.

#include <algorithm>
#include <cmath>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

SceneSpec fast_spec() { return settings(Mode::kCcd, Accuracy::kFast, Scalar::kF64); }

// Everything far apart, and everything on one spot: few pairs, and millions.
Case sparse_case() { return soup(60, 1500, 100, 0.2, 0.01); }
Case dense_case() { return soup(61, 1500, 0.01, 0.2, 0.01); }

using DetectorState = OnBackend<>;

TEST_F(DetectorState, StartIsWhereTheLastFrameEnded) {
  const auto scene = scenes::make_scene("funnel", 0.3);
  std::unique_ptr<Detector> kept;
  for (int step = 0; step < 4; ++step) {
    const Case c = case_of(*scene, 0.5 + 0.02 * step, 0.52 + 0.02 * step);
    if (!kept) kept = Detector::create(spec_for(c, fast_spec()));
    const Frame frame(c, Mode::kCcd, Scalar::kF64, step == 0);
    FrameInput input = frame.input();
    if (step > 0)
      for (MeshPositions& update : input.updates) update.start = {};
    const FrameResult expected = run_case(c, fast_spec());
    EXPECT_TRUE(same_contacts(expected, kept->detect(input))) << step;
  }
}

TEST_F(DetectorState, AMeshThatIsNotNamedStandsStill) {
  Case c = soup(62, 300, 1, 0.2, 0.1);
  const Case second = soup(63, 300, 1, 0.2, 0.1);
  add_mesh(c, second.meshes[0].triangles, second.start[0], second.end[0]);
  auto kept = Detector::create(spec_for(c, fast_spec()));
  kept->detect(Frame(c, Mode::kCcd, Scalar::kF64).input());

  Case next = c;  // mesh 0 goes back, mesh 1 rests where it arrived
  std::swap(next.start[0], next.end[0]);
  next.start[1] = next.end[1];
  const Frame frame(next, Mode::kCcd, Scalar::kF64);
  FrameInput input = frame.input();
  input.updates.pop_back();
  EXPECT_TRUE(same_contacts(run_case(next, fast_spec()), kept->detect(input)));
}

TEST_F(DetectorState, ManyFramesEqualFreshScenes) {
  const auto scene = scenes::make_scene("reef_knot", 0.3);
  auto kept = Detector::create(spec_for(case_of(*scene, 0, 0), fast_spec()));
  for (int step = 0; step < 12; ++step) {
    const double t = (step * 5 % 12) / 12.0;
    const Case c = case_of(*scene, t, t + 1.0 / 60);
    const Frame frame(c, Mode::kCcd, Scalar::kF64, step == 0);
    EXPECT_TRUE(same_contacts(run_case(c, fast_spec()), kept->detect(frame.input()))) << step;
  }
}

TEST_F(DetectorState, GrownBuffersGiveTheSameResult) {
  const Case dense = dense_case();
  auto kept = Detector::create(spec_for(dense, fast_spec()));
  kept->detect(Frame(sparse_case(), Mode::kCcd, Scalar::kF64).input());
  const Frame frame(dense, Mode::kCcd, Scalar::kF64);
  const FrameResult grown = kept->detect(frame.input());
  const FrameResult warm = kept->detect(frame.input());
  EXPECT_EQ(warm.replays, 0u) << "buffers keep their size";
  EXPECT_TRUE(same_contacts(grown, warm));
  EXPECT_TRUE(same_contacts(grown, run_case(dense, fast_spec())));
}

uint64_t bytes_of(const Detector& detector) {
  uint64_t sum = 0;
  for (const MemoryPart& part : detector.memory()) sum += part.bytes;
  return sum;
}

TEST_F(DetectorState, TooSmallABudgetFailsTheFrameAlone) {
  const Case sparse = sparse_case();
  const Frame sparse_frame(sparse, Mode::kCcd, Scalar::kF64), dense_frame(dense_case(), Mode::kCcd, Scalar::kF64);
  SceneSpec spec = spec_for(sparse, fast_spec());
  auto unbounded = Detector::create(spec);
  const FrameResult expected = unbounded->detect(sparse_frame.input());
  spec.memory_budget = bytes_of(*unbounded) * 3 / 2 + (4u << 20);

  auto bounded = Detector::create(spec);
  EXPECT_TRUE(same_contacts(expected, bounded->detect(sparse_frame.input())));
  EXPECT_THROW(bounded->detect(dense_frame.input()), ResourceExhausted);
  EXPECT_LE(bytes_of(*bounded), spec.memory_budget);
  FrameInput rest = sparse_frame.input();
  rest.updates[0].start = {};  // from the end of the good frame, not of the failed one
  unbounded->detect(rest);
  EXPECT_TRUE(same_contacts(unbounded->detect(sparse_frame.input()), bounded->detect(sparse_frame.input())));
}

TEST_F(DetectorState, FailedFrameLeavesPositions) {
  const Case sparse = sparse_case();
  const Frame sparse_frame(sparse, Mode::kCcd, Scalar::kF64), dense_frame(dense_case(), Mode::kCcd, Scalar::kF64);
  SceneSpec spec = spec_for(sparse, fast_spec());
  auto unbounded = Detector::create(spec);
  unbounded->detect(sparse_frame.input());
  spec.memory_budget = bytes_of(*unbounded) * 3 / 2 + (4u << 20);
  auto bounded = Detector::create(spec);
  bounded->detect(sparse_frame.input());
  EXPECT_THROW(bounded->detect(dense_frame.input()), ResourceExhausted);
  FrameInput rest = sparse_frame.input();
  rest.updates[0].start = {};
  EXPECT_TRUE(same_contacts(unbounded->detect(rest), bounded->detect(rest)));
}

TEST_F(DetectorState, AHopelessBudgetIsRefused) {
  SceneSpec spec = spec_for(sparse_case(), fast_spec());
  spec.memory_budget = 1000;
  EXPECT_THROW(
      {
        auto detector = Detector::create(spec);
        detector->detect(Frame(sparse_case(), Mode::kCcd, Scalar::kF64).input());
      },
      ResourceExhausted);
}

TEST_F(DetectorState, CancellingLeavesTheSceneAsItWas) {
  const Case c = soup(64, 500, 1, 0.2, 0.1), other = soup(65, 500, 1, 0.2, 0.1);
  auto kept = Detector::create(spec_for(c, fast_spec()));
  auto twin = Detector::create(spec_for(c, fast_spec()));
  const Frame first(c, Mode::kCcd, Scalar::kF64), second(other, Mode::kCcd, Scalar::kF64);
  kept->detect(first.input());
  twin->detect(first.input());

  FrameInput rest = second.input();
  rest.updates[0].start = {};  // from where the last frame left the mesh
  const FrameResult expected = twin->detect(rest);
  int times_cancelled = 0;
  for (bool done = false; !done;) {
    int asked = 0;
    rest.cancelled = [&] { return asked++ >= times_cancelled; };
    try {
      EXPECT_TRUE(same_contacts(expected, kept->detect(rest)));
      done = true;
    } catch (const Cancelled&) {
      ASSERT_LT(times_cancelled += 1 + times_cancelled / 2, 100'000);  // it is asked within stages too
    }
  }
  EXPECT_GT(times_cancelled, 2);
}

/// Every third vertex of mesh 1, from its second one on.
Positions read_some(Detector& detector, const Case& c) {
  const VertexSample sample{c.start[0].size() + 1, 3, (c.start[1].size() + 1) / 3};
  Positions some(sample.count);
  detector.read_positions(sample, std::as_writable_bytes(std::span(some)));
  return some;
}
Positions some_of(const Case& c) {
  Positions some;
  for (size_t i = 1; i < c.end[1].size(); i += 3) some.push_back(c.end[1][i]);
  return some;
}

TEST_F(DetectorState, PositionsAreThoseAfterTheLastFrameThatWasApplied) {
  for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
    SceneSpec spec = fast_spec();
    spec.mode = mode;
    spec.thickness = mode == Mode::kDcd ? 0.01 : 0;
    Case c = soup(62, 100, 1, 0.2, 0.1);
    const Case second = soup(63, 100, 1, 0.2, 0.1);
    add_mesh(c, second.meshes[0].triangles, second.start[0], second.end[0]);
    auto kept = Detector::create(spec_for(c, spec));
    EXPECT_THROW(read_some(*kept, c), std::logic_error);
    kept->detect(Frame(c, mode, Scalar::kF64).input());
    EXPECT_EQ(read_some(*kept, c), some_of(c));

    Case next = c;
    std::swap(next.start[1], next.end[1]);
    const Frame frame(next, mode, Scalar::kF64);
    FrameInput input = frame.input();
    int asked = 0;
    input.cancelled = [&] { return asked++ >= 3; };  // once its positions are in place
    EXPECT_THROW(kept->detect(input), Cancelled);
    EXPECT_EQ(read_some(*kept, c), some_of(c));
    input.cancelled = {};
    kept->detect(input);
    EXPECT_EQ(read_some(*kept, c), some_of(next));
  }
}

TEST_F(DetectorState, CancelledFirstFrameIsStillTheFirst) {
  const Case c = soup(66, 200, 1, 0.2, 0.1);
  auto detector = Detector::create(spec_for(c, fast_spec()));
  const Frame frame(c, Mode::kCcd, Scalar::kF64);
  FrameInput input = frame.input();
  input.cancelled = [] { return true; };
  EXPECT_THROW(detector->detect(input), Cancelled);
  EXPECT_THROW(detector->detect(FrameInput{}), InvalidInput);
  EXPECT_TRUE(same_contacts(run_case(c, fast_spec()), detector->detect(frame.input())));
}

// create() asks repeatedly while it makes the tables.
TEST_F(DetectorState, ItsMakingCanBeCancelled) {
  constexpr uint32_t kTriangles = 1 << 18;
  SceneSpec spec = fast_spec();
  MeshSpec& mesh = spec.meshes.emplace_back();
  mesh.vertex_count = kTriangles + 2;
  for (uint32_t i = 0; i < kTriangles; ++i) mesh.triangles.push_back({i, i + 1, i + 2});
  int asked = 0;
  EXPECT_THROW(Detector::create(spec, [&] { return ++asked > 2; }), Cancelled);
  EXPECT_EQ(asked, 3);
}

TEST_F(DetectorState, DetectorsAreIndependent) {
  const Case a = soup(67, 300, 1, 0.2, 0.1), b = soup(68, 400, 1, 0.2, 0.1);
  auto one = Detector::create(spec_for(a, fast_spec())), two = Detector::create(spec_for(b, fast_spec()));
  const FrameResult ra = one->detect(Frame(a, Mode::kCcd, Scalar::kF64).input());
  const FrameResult rb = two->detect(Frame(b, Mode::kCcd, Scalar::kF64).input());
  EXPECT_TRUE(same_contacts(ra, run_case(a, fast_spec())));
  EXPECT_TRUE(same_contacts(rb, run_case(b, fast_spec())));
}

/// A fine grid that goes far for its edges, and a dense heap that stays.
Case far_case() {
  Case c = dense_case();
  std::vector<std::array<uint32_t, 3>> triangles;
  Positions from, to;
  for (uint32_t i = 0; i < 20; ++i)
    for (uint32_t j = 0; j < 20; ++j) {
      from.push_back({0.03125 * i, 0.03125 * j, 5});
      to.push_back({0.03125 * i, 0.03125 * j, 6.5});
      if (i + 1 < 20 && j + 1 < 20) triangles.push_back({20 * i + j, 20 * i + j + 1, 20 * i + j + 20});
    }
  add_mesh(c, triangles, from, to);
  return c;
}

TEST_F(DetectorState, AFrameThatIsGivenUpTellsWhatItHadFound) {
  const Case c = far_case();
  const Frame frame(c, Mode::kCcd, Scalar::kF64);
  const uint64_t all_pairs = run_case(c, fast_spec()).counts.pairs;
  uint64_t most_pairs = 0, told = 0;
  for (int last = 0, is_over = 0; is_over == 0; last += 1 + last / 4) {
    FrameProgress progress;
    FrameInput input = frame.input();
    int asked = 0;
    input.cancelled = [&] { return asked++ >= last; };
    input.progress = &progress;
    try {
      Detector::create(spec_for(c, fast_spec()))->detect(input);
      is_over = 1;
      EXPECT_EQ(progress.pairs + progress.far_meshes.size(), 0u) << "of a frame that ended well";
    } catch (const Cancelled&) {
      EXPECT_LE(progress.pairs, all_pairs);
      most_pairs = std::max(most_pairs, progress.pairs);
      if (progress.far_meshes.empty()) continue;
      ++told;
      ASSERT_EQ(progress.far_meshes.size(), 1u);
      const auto& [mesh, way, edge] = progress.far_meshes[0];
      EXPECT_EQ(mesh, 1u);
      EXPECT_EQ(way, 1.5);
      EXPECT_NEAR(edge, 0.03125 * (2 + std::sqrt(2)) / 3, 1e-12);
    }
  }
  EXPECT_GT(told, 0u);
  EXPECT_GT(most_pairs, 0u);
}

TEST_F(DetectorState, AFrameThatFindsNoMemoryTellsWhatItHadFound) {
  const Case c = dense_case();
  SceneSpec spec = spec_for(c, fast_spec());
  const FrameResult whole = run_case(c, fast_spec());
  const auto scene = Detector::create(spec);
  const Frame frame(c, Mode::kCcd, Scalar::kF64);
  scene->detect(frame.input());
  uint64_t needed = 0;
  for (const MemoryPart& part : scene->memory()) needed += part.bytes;
  spec.memory_budget = needed / 2;
  FrameProgress progress;
  FrameInput input = frame.input();
  input.progress = &progress;
  EXPECT_THROW(Detector::create(spec)->detect(input), ResourceExhausted);
  EXPECT_GT(progress.pairs, 0u);
  EXPECT_LE(progress.pairs, whole.counts.pairs);
}

}  // namespace
}  // namespace collided::test
