// Accuracy, delta and report of a scene and of a single frame; what they cannot be; what the input can resolve.

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

constexpr Accuracy kAllLevels[] = {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified,
                                   Accuracy::kExact};

struct Options {
  std::optional<Accuracy> accuracy = {};
  std::optional<double> delta = {};
  std::optional<Report> report = {};
};

FrameInput with(FrameInput frame, const Options& options) {
  frame.accuracy = options.accuracy;
  frame.delta = options.delta;
  frame.report = options.report;
  return frame;
}
SceneSpec with(SceneSpec spec, const Options& options) {
  spec.accuracy = options.accuracy.value_or(spec.accuracy);
  spec.delta = options.delta.value_or(spec.delta);
  spec.report = options.report.value_or(spec.report);
  return spec;
}

// Moving triangles and a static wall.
Case small_case() {
  Case c = soup(100, 150, 1, 0.25, 0.1);
  const Case wall = soup(101, 50, 1, 0.3, 0);
  add_mesh(c, wall.meshes[0].triangles, wall.start[0], {}, true);
  return c;
}

void expect_same_answer(const FrameResult& expected, const FrameResult& got) {
  EXPECT_TRUE(same_contacts(expected, got));
  EXPECT_TRUE(same_bytes(expected.triangle_triangle, got.triangle_triangle));
  EXPECT_EQ(expected.earliest_toi, got.earliest_toi);
  EXPECT_EQ(expected.any_contact, got.any_contact);
  EXPECT_EQ(expected.input_resolution, got.input_resolution);
}

using FrameOptions = OnBackend<>;

// Each frame with options is followed by one without.
void expect_options_hold_for_one_frame(const Case& c, const SceneSpec& settings, const std::vector<Options>& frames) {
  const Frame all(c, settings.mode, settings.scalar), moving(c, settings.mode, settings.scalar, false);
  auto scene = Detector::create(spec_for(c, settings));
  const FrameResult usual = scene->detect(all.input());
  for (size_t i = 0; i < frames.size(); ++i) {
    SCOPED_TRACE(i);
    expect_same_answer(run_case(c, with(settings, frames[i])), scene->detect(with(moving.input(), frames[i])));
    expect_same_answer(usual, scene->detect(moving.input()));
  }
}

TEST_F(FrameOptions, HoldForOneContinuousFrame) {
  std::vector<Options> frames;
  for (Accuracy accuracy : kAllLevels) frames.push_back({accuracy});
  for (Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kExact})
    frames.push_back({accuracy, 0.01, Report::kEarliestOnly});
  frames.push_back({.accuracy = Accuracy::kFast, .report = Report::kAnyHit});
  frames.push_back({.delta = 0.01});
  for (Report report : {Report::kEarliestOnly, Report::kAnyHit}) frames.push_back({.report = report});
  expect_options_hold_for_one_frame(small_case(), settings(Mode::kCcd, Accuracy::kCertified), frames);
}

TEST_F(FrameOptions, HoldForOneDiscreteFrame) {
  std::vector<Options> frames;
  for (Accuracy accuracy : kAllLevels) frames.push_back({accuracy});
  frames.push_back({.report = Report::kAnyHit});
  SceneSpec spec = settings(Mode::kDcd, Accuracy::kFast, Scalar::kF32, 0.01);
  spec.kinds.triangle_triangle = true;
  expect_options_hold_for_one_frame(small_case(), spec, frames);
}

// A frame may leave the scene's own delta and report.
TEST_F(FrameOptions, ReplaceThoseOfTheScene) {
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kGuarded);
  spec.delta = 0.02;
  spec.report = Report::kEarliestOnly;
  expect_options_hold_for_one_frame(small_case(), spec,
                                    {{.delta = 0.0}, {.report = Report::kAll}, {{}, 0.0, Report::kAll}});
}

TEST_F(FrameOptions, ACandidatesSceneCanBeAskedForMore) {
  const Case c = small_case();
  std::vector<Options> frames;
  for (Accuracy accuracy : {Accuracy::kExact, Accuracy::kFast, Accuracy::kCertified}) frames.push_back({accuracy});
  frames.push_back({Accuracy::kExact, {}, Report::kEarliestOnly});
  frames.push_back({Accuracy::kExact, {}, Report::kAnyHit});
  expect_options_hold_for_one_frame(c, settings(Mode::kCcd, Accuracy::kCandidates), frames);
  expect_options_hold_for_one_frame(c, settings(Mode::kDcd, Accuracy::kCandidates, Scalar::kF64, 0.01),
                                    {{Accuracy::kExact}, {Accuracy::kGuarded}});
  const FrameResult exact = run_case(c, settings(Mode::kCcd, Accuracy::kExact));
  EXPECT_GT(exact.edge_edge.size(), 0u) << "else edges of the frame with more accuracy are not put to the test";
}

// The first frame may have options too.
TEST_F(FrameOptions, HoldForTheFirstFrame) {
  const Case c = small_case();
  const Frame frame(c, Mode::kCcd, Scalar::kF64);
  auto scene = Detector::create(spec_for(c, settings(Mode::kCcd, Accuracy::kCandidates)));
  expect_same_answer(run_case(c, settings(Mode::kCcd, Accuracy::kExact)),
                     scene->detect(with(frame.input(), {Accuracy::kExact})));
}

uint64_t bytes_of(const Detector& detector, const std::string& part) {
  for (const MemoryPart& p : detector.memory())
    if (p.part == part) return p.bytes;
  return 0;
}

// Room for what a frame asks for is taken when it comes, not before.
TEST_F(FrameOptions, TakeNoMemoryBeforeTheyAreUsed) {
  const Case c = lattice(102, 60, 6);  // exact touches: EXACT has something to decide
  const Frame frame(c, Mode::kCcd, Scalar::kF64);
  auto scene = Detector::create(spec_for(c, settings(Mode::kCcd, Accuracy::kCandidates)));
  scene->detect(frame.input());
  EXPECT_EQ(bytes_of(*scene, "contacts"), 0u);
  scene->detect(with(frame.input(), {Accuracy::kCertified}));
  const uint64_t contacts = bytes_of(*scene, "contacts");
  EXPECT_GT(contacts, 0u);
  scene->detect(with(frame.input(), {.accuracy = Accuracy::kCertified, .report = Report::kAnyHit}));
  EXPECT_EQ(bytes_of(*scene, "contacts"), contacts);
  EXPECT_EQ(bytes_of(*scene, "exact"), 0u);
  scene->detect(with(frame.input(), {.accuracy = Accuracy::kCertified, .report = Report::kEarliestOnly}));
  EXPECT_GT(bytes_of(*scene, "contacts"), contacts) << "a second list for the earliest ones";
  EXPECT_EQ(bytes_of(*scene, "exact"), 0u);
  scene->detect(with(frame.input(), {Accuracy::kExact}));
  EXPECT_GT(bytes_of(*scene, "exact"), 0u);
}

struct Refusal {
  Mode mode;
  Options options;
  std::string field;
};

// Refused for a scene and for a frame of a scene without them; nothing else of the scene matters.
std::vector<Refusal> refusals() {
  std::vector<Refusal> list;
  for (double bad : {-1.0, -1e-300, std::nan(""), HUGE_VAL, 1e38})  // above an eighth of the largest float
    list.push_back({Mode::kCcd, {.delta = bad}, "delta"});
  list.push_back({Mode::kDcd, {.delta = -1.0}, "delta"});
  for (Accuracy accuracy : {Accuracy::kCandidates, Accuracy::kFast})
    list.push_back({Mode::kCcd, {accuracy, {}, Report::kEarliestOnly}, "report"});
  for (Accuracy accuracy : kAllLevels) list.push_back({Mode::kDcd, {accuracy, {}, Report::kEarliestOnly}, "report"});
  for (Mode mode : {Mode::kCcd, Mode::kDcd})
    list.push_back({mode, {Accuracy::kCandidates, {}, Report::kAnyHit}, "report"});
  return list;
}

using RefusedOptions = OnBackend<::testing::TestWithParam<Refusal>>;

TEST_P(RefusedOptions, OfAScene) {
  const auto& [mode, options, field] = GetParam();
  const SceneSpec spec = settings(mode, Accuracy::kCertified, Scalar::kF32, 0.01);
  EXPECT_EQ(field, refused_field([&] { Detector::create(spec_for(small_case(), with(spec, options))); }));
}

TEST_P(RefusedOptions, OfAFrameLeaveTheScene) {
  const auto& [mode, options, field] = GetParam();
  const Case c = rounded(small_case(), Scalar::kF32);
  Case moved = c;
  for (Vec3d& p : moved.end[0]) p[0] += 0.25;
  const SceneSpec spec = settings(mode, Accuracy::kCertified, Scalar::kF32, 0.01);
  const Frame all(c, mode, Scalar::kF32), moving(c, mode, Scalar::kF32, false);
  const Frame elsewhere(rounded(moved, Scalar::kF32), mode, Scalar::kF32, false);
  auto scene = Detector::create(spec_for(c, spec)), twin = Detector::create(spec_for(c, spec));
  scene->detect(all.input());
  twin->detect(all.input());
  EXPECT_EQ(field, refused_field([&] { scene->detect(with(elsewhere.input(), options)); }));
  FrameInput next = moving.input();
  next.updates[0].start = {};  // from where the good frame ended, not the refused one
  expect_same_answer(twin->detect(next), scene->detect(next));
}

INSTANTIATE_TEST_SUITE_P(Options, RefusedOptions, ::testing::ValuesIn(refusals()),
                         [](const auto& info) { return info.param.field + std::to_string(info.index); });

TEST_F(FrameOptions, DiscreteFramesAtFastNeedADistance) {
  const Case c = small_case();
  const Frame frame(c, Mode::kDcd, Scalar::kF64);
  const SceneSpec touching = settings(Mode::kDcd, Accuracy::kCertified);
  auto scene = Detector::create(spec_for(c, touching));
  EXPECT_EQ("thickness", refused_field([&] { scene->detect(with(frame.input(), {Accuracy::kFast})); }));
  EXPECT_NO_THROW(scene->detect(with(frame.input(), {Accuracy::kGuarded})));
}

TEST_F(FrameOptions, TrianglePairsAreDiscrete) {
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
  spec.kinds.triangle_triangle = true;
  EXPECT_EQ("triangle_triangle", refused_field([&] { Detector::create(spec_for(small_case(), spec)); }));
}

class InputResolution : public OnBackend<::testing::TestWithParam<Scalar>> {
 protected:
  double far() const { return GetParam() == Scalar::kF32 ? 1e8 : 1e17; }

  bool is_coarse(const Case& c, Accuracy accuracy, double delta = 0, Mode mode = Mode::kCcd) const {
    SceneSpec spec = settings(mode, accuracy, GetParam(), 0.01);
    spec.delta = delta;
    return run_case(c, spec).input_resolution;
  }
};

// The triangles are about 0.2 long.
TEST_P(InputResolution, IsThatOfMostTriangles) {
  const Case near = soup(103, 60, 1, 0.2, 0.1), away = soup(103, 60, 1, 0.2, 0.1, {0, far(), 0});
  for (Accuracy accuracy : kAllLevels)
    for (Mode mode : {Mode::kCcd, Mode::kDcd}) {
      EXPECT_FALSE(is_coarse(near, accuracy, 0, mode)) << level_name(accuracy);
      EXPECT_EQ(is_coarse(away, accuracy, 0, mode), accuracy >= Accuracy::kGuarded) << level_name(accuracy);
    }
}

TEST_P(InputResolution, AFewSmallTrianglesDoNotCount) {
  Case c = soup(104, 60, 1, 0.2, 0.1);
  const double tiny = GetParam() == Scalar::kF32 ? 1e-5 : 1e-14;
  const auto add_tiny = [&](uint32_t seed, uint32_t count) {
    const Case part = soup(seed, count, 1, tiny, 0, {1, 1, 1});
    add_mesh(c, part.meshes[0].triangles, part.start[0]);
  };
  add_tiny(105, 50);
  EXPECT_FALSE(is_coarse(c, Accuracy::kGuarded));
  add_tiny(106, 30);
  EXPECT_TRUE(is_coarse(c, Accuracy::kGuarded));
}

// The largest coordinate is 1000, in [2^9, 2^10).
TEST_P(InputResolution, IsHeldAgainstDeltaIfThereIsOne) {
  Case c = soup(107, 20, 1, 0.2, 0.1);
  c.end[0][5][1] = -1000;
  const double spacing = GetParam() == Scalar::kF32 ? 0x1p-14 : 0x1p-43;
  for (Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact}) {
    EXPECT_FALSE(is_coarse(c, accuracy, spacing));
    EXPECT_TRUE(is_coarse(c, accuracy, 0.999 * spacing));
  }
  EXPECT_FALSE(is_coarse(c, Accuracy::kFast, 0.999 * spacing));
}

INSTANTIATE_TEST_SUITE_P(Scalars, InputResolution, ::testing::Values(Scalar::kF32, Scalar::kF64),
                         [](const auto& info) { return info.param == Scalar::kF32 ? "F32" : "F64"; });

using Unused = std::vector<std::string>;

TEST_F(FrameOptions, ThatHaveNoEffectAreTold) {
  const Case c = small_case();
  const auto unused_in = [&](const SceneSpec& spec, const std::function<void(FrameInput&)>& set = {}) {
    const Frame frame(c, spec.mode, spec.scalar);
    FrameInput input = frame.input();
    if (set) set(input);
    return Detector::create(spec_for(c, spec))->detect(input).unused_options;
  };
  SceneSpec apart = settings(Mode::kCcd, Accuracy::kCertified);
  EXPECT_EQ(unused_in(apart), Unused{});
  apart.min_separation = 0.01;
  EXPECT_EQ(unused_in(apart), Unused{"min_separation"});
  EXPECT_EQ(unused_in(apart, [](FrameInput& f) { f.advance = true; }), Unused{});
  apart.mode = Mode::kBoth;
  EXPECT_EQ(unused_in(apart), Unused{}) << "it is the contact distance of CCD frames";

  SceneSpec crossing = settings(Mode::kDcd, Accuracy::kExact, Scalar::kF64, 0.1);
  EXPECT_EQ(unused_in(crossing), Unused{});
  crossing.kinds = {.triangle_triangle = true};
  EXPECT_EQ(unused_in(crossing), Unused{"thickness"});
  crossing.thickness = 0;
  SceneSpec thick = spec_for(c, crossing);
  thick.meshes[0].half_thickness = 0.1;
  const Frame frame(c, thick.mode, thick.scalar);
  EXPECT_EQ(Detector::create(thick)->detect(frame.input()).unused_options, Unused{"meshes[0].half_thickness"});

  SceneSpec coarse = settings(Mode::kCcd, Accuracy::kFast);
  coarse.delta = 1e-6;
  EXPECT_EQ(unused_in(coarse), Unused{"delta"});
  EXPECT_EQ(unused_in(coarse, [](FrameInput& f) { f.accuracy = Accuracy::kGuarded; }), Unused{});
}

TEST_F(FrameOptions, ExclusionsOfMeshesWithoutSelfContactsAreTold) {
  Case c = small_case();
  const SceneSpec plain = settings(Mode::kCcd, Accuracy::kCertified);
  const auto unused = [&] {
    const Frame frame(c, plain.mode, plain.scalar);
    return Detector::create(spec_for(c, plain))->detect(frame.input()).unused_options;
  };
  c.meshes[0].excluded_rings = 1;
  EXPECT_EQ(unused(), Unused{});
  c.meshes[0].self_contacts = false;
  EXPECT_EQ(unused(), Unused{"meshes[0].excluded_rings"});
}

}  // namespace
}  // namespace collided::test
