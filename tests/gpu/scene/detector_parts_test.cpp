// A scene holds and computes only what its spec asks for.

#include <algorithm>
#include <cstdlib>
#include <set>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

struct Footprint {
  std::set<std::string> parts, stages;
  uint64_t bytes = 0;
  FrameResult result;
};

Case small_case() { return soup(70, 400, 1, 0.2, 0.05); }

Footprint footprint(const Case& c, const SceneSpec& settings) {
  auto detector = Detector::create(spec_for(c, settings));
  Footprint f;
  f.result = detector->detect(Frame(c, settings.mode, settings.scalar).input());
  for (const StageTime& stage : f.result.stages) f.stages.insert(stage.stage);
  for (const MemoryPart& part : detector->memory()) {
    EXPECT_TRUE(f.parts.insert(part.part).second) << "twice: " << part.part;
    f.bytes += part.bytes;
  }
  return f;
}

std::string text(const std::set<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += name + " ";
  return all;
}

// `less` has strictly fewer stages than `more`, and no part that `more` lacks. Lists hold one kind at a time, so that
// the kind with fewer candidates may add no bytes.
void expect_fewer(const Footprint& less, const Footprint& more) {
  EXPECT_TRUE(std::includes(more.parts.begin(), more.parts.end(), less.parts.begin(), less.parts.end()))
      << text(less.parts) << "| " << text(more.parts);
  EXPECT_TRUE(std::includes(more.stages.begin(), more.stages.end(), less.stages.begin(), less.stages.end()))
      << text(less.stages) << "| " << text(more.stages);
  EXPECT_LT(less.stages.size(), more.stages.size()) << text(more.stages);
  EXPECT_LE(less.bytes, more.bytes);
}

using DetectorParts = OnBackend<>;

TEST_F(DetectorParts, VertexTriangleAlone) {
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kFast);
  const Footprint both = footprint(small_case(), spec);
  spec.kinds.edge_edge = false;
  const Footprint alone = footprint(small_case(), spec);
  expect_fewer(alone, both);
  EXPECT_LT(alone.bytes, both.bytes);
  EXPECT_EQ(alone.result.edge_edge.size(), 0u);
  EXPECT_EQ(alone.result.counts.candidates.edge_edge, 0u);
  EXPECT_TRUE(same_bytes(alone.result.vertex_triangle, both.result.vertex_triangle));
}

TEST_F(DetectorParts, EdgeEdgeAlone) {
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kFast);
  const Footprint both = footprint(small_case(), spec);
  spec.kinds.vertex_triangle = false;
  const Footprint alone = footprint(small_case(), spec);
  expect_fewer(alone, both);
  EXPECT_EQ(alone.result.vertex_triangle.size(), 0u);
  EXPECT_EQ(alone.result.counts.candidates.vertex_triangle, 0u);
  EXPECT_TRUE(same_bytes(alone.result.edge_edge, both.result.edge_edge));
}

TEST_F(DetectorParts, CandidatesHaveNoNarrowPhase) {
  const Footprint fast = footprint(small_case(), settings(Mode::kCcd, Accuracy::kFast));
  const Footprint candidates = footprint(small_case(), settings(Mode::kCcd, Accuracy::kCandidates));
  EXPECT_LT(candidates.stages.size(), fast.stages.size()) << text(fast.stages);
  EXPECT_EQ(candidates.result.counts.contacts.vertex_triangle + candidates.result.counts.contacts.edge_edge, 0u);
  EXPECT_EQ(candidates.result.counts.candidates.vertex_triangle, fast.result.counts.candidates.vertex_triangle);
  EXPECT_EQ(candidates.result.counts.candidates.edge_edge, fast.result.counts.candidates.edge_edge);
}

// The last good frame's positions are where a continuous step begins: such scenes need no copy of them.
TEST_F(DetectorParts, ScenesKeepThePreviousPositionsOnce) {
  const auto parts = [](Mode mode) {
    const Case c = small_case();
    const SceneSpec spec = settings(mode, Accuracy::kCandidates);
    const auto detector = Detector::create(spec_for(c, spec));
    const Frame frame(c, mode, spec.scalar);
    FrameInput input = frame.input();
    for (MeshPositions& update : input.updates) update.start = {};
    for (int i = 0; i < 2; ++i) detector->detect(input);
    std::set<std::string> names;
    for (const MemoryPart& part : detector->memory()) names.insert(part.part);
    return names;
  };
  const auto continuous = parts(Mode::kCcd), discrete = parts(Mode::kDcd);
  EXPECT_TRUE(continuous.contains("start_positions") && !continuous.contains("last_good")) << text(continuous);
  EXPECT_TRUE(discrete.contains("last_good") && !discrete.contains("start_positions")) << text(discrete);
}

// The first frame of a scene that asks for little, and of those that ask for one thing more.
TEST_F(DetectorParts, WhatIsNotAskedForTakesNoMemory) {
  const auto parts_with = [](const auto& change) {
    SceneSpec spec = settings(Mode::kDcd, Accuracy::kCandidates);
    spec.engine = Engine::kOctree;
    spec.kinds = {.vertex_triangle = true};
    Case c = small_case();
    change(spec, c);
    return footprint(c, spec).parts;
  };
  const std::set<std::string> least = parts_with([](SceneSpec&, Case&) {});
  const auto expect_adds = [&](const std::set<std::string>& added, const auto& change) {
    const std::set<std::string> parts = parts_with(change);
    for (const std::string& part : added) {
      EXPECT_FALSE(least.contains(part)) << part << " is among " << text(least);
      EXPECT_TRUE(parts.contains(part)) << part << " is not among " << text(parts);
    }
  };
  expect_adds({"start_positions"}, [](SceneSpec& spec, Case&) { spec.mode = Mode::kCcd; });
  expect_adds({"edges"}, [](SceneSpec& spec, Case&) { spec.kinds.edge_edge = true; });
  expect_adds({"pairs", "contacts"}, [](SceneSpec& spec, Case&) { spec.kinds.triangle_triangle = true; });
  expect_adds({"candidates", "contacts"}, [](SceneSpec& spec, Case&) { spec.accuracy = Accuracy::kGuarded; });
  expect_adds({"bvh"}, [](SceneSpec& spec, Case&) { spec.engine = Engine::kLbvh; });
  expect_adds({"all_pairs"}, [](SceneSpec& spec, Case&) { spec.engine = Engine::kAllPairs; });
  expect_adds({"pair_filter"}, [](SceneSpec&, Case& c) { c.meshes[0].groups = 2; });
  expect_adds({"half_thickness"}, [](SceneSpec&, Case& c) { c.meshes[0].half_thickness = 0.01; });
  EXPECT_FALSE(parts_with([](SceneSpec& spec, Case&) { spec.engine = Engine::kLbvh; }).contains("octree"));
}

// A list for each of the things that a level, a report or a field needs.
TEST_F(DetectorParts, EachLevelReportAndFieldAddsItsOwnMemory) {
  const auto bytes_with = [](const auto& change) {
    SceneSpec spec = settings(Mode::kCcd, Accuracy::kFast);
    change(spec);
    return estimate_scene(spec, 1000, 1000);
  };
  const auto bytes = [](const SceneEstimate& estimate) {
    uint64_t sum = 0;
    for (const MemoryPart& part : estimate.memory) sum += part.bytes;
    return sum;
  };
  const uint64_t fast = bytes(bytes_with([](SceneSpec&) {}));
  const uint64_t guarded = bytes(bytes_with([](SceneSpec& spec) { spec.accuracy = Accuracy::kGuarded; }));
  const uint64_t certified = bytes(bytes_with([](SceneSpec& spec) { spec.accuracy = Accuracy::kCertified; }));
  EXPECT_LT(fast, guarded);
  EXPECT_LT(guarded, certified);
  EXPECT_LT(guarded, bytes(bytes_with([](SceneSpec& spec) {
              spec.accuracy = Accuracy::kGuarded;
              spec.report = Report::kEarliestOnly;
            })));
  for (const ContactField field : {ContactField::kWeights, ContactField::kNormals})
    EXPECT_LT(fast, bytes(bytes_with([&](SceneSpec& spec) { spec.fields = spec.fields.with(field); })));
}

TEST_F(DetectorParts, MemoryOfFloatsIsLess) {
  EXPECT_LT(footprint(small_case(), settings(Mode::kCcd, Accuracy::kCandidates, Scalar::kF32)).bytes,
            footprint(small_case(), settings(Mode::kCcd, Accuracy::kCandidates, Scalar::kF64)).bytes);
}

TEST_F(DetectorParts, StaticMeshesAreNotTestedWithEachOther) {
  Case c;
  for (uint32_t seed : {71u, 72u}) {
    const Case part = soup(seed, 200, 1, 0.2, 0);
    add_mesh(c, part.meshes[0].triangles, part.start[0], {}, true);
  }
  const FrameResult r = run_case(c, settings(Mode::kDcd, Accuracy::kCandidates));
  EXPECT_EQ(r.vertex_triangle.size() + r.edge_edge.size(), 0u);
}

// A static mesh gives the contacts that it would give as a mesh that stands still, less those with itself.
TEST_F(DetectorParts, StaticMeshEqualsAMeshThatStandsStill) {
  Case c = soup(73, 300, 1, 0.2, 0.1);
  const Case wall = soup(74, 200, 1, 0.2, 0);
  add_mesh(c, wall.meshes[0].triangles, wall.start[0], {}, true);
  Case still = c;
  still.meshes[1].motion = MeshMotion::kDeformable;
  still.meshes[1].self_contacts = false;
  const SceneSpec spec = settings(Mode::kCcd, Accuracy::kFast);
  EXPECT_TRUE(same_contacts(run_case(c, spec), run_case(still, spec)));
}

TEST_F(DetectorParts, StaticMeshesStayOverManyFrames) {
  Case c = soup(75, 300, 1, 0.2, 0.1);
  const Case wall = soup(76, 200, 1, 0.2, 0);
  add_mesh(c, wall.meshes[0].triangles, wall.start[0], {}, true);
  const SceneSpec spec = settings(Mode::kCcd, Accuracy::kFast);
  auto kept = Detector::create(spec_for(c, spec));
  for (int step = 0; step < 5; ++step) {
    EXPECT_TRUE(same_contacts(run_case(c, spec), kept->detect(Frame(c, spec.mode, spec.scalar, step == 0).input())));
    c.start[0] = c.end[0];
    for (Vec3d& p : c.end[0]) p[step % 3] += 0.07;  // also out of the first frame's domain
  }
}

TEST_F(DetectorParts, StageNamesAndDeviceAreGiven) {
  const Case c = small_case();
  auto detector = Detector::create(spec_for(c, settings(Mode::kCcd, Accuracy::kFast)));
  EXPECT_EQ(detector->device().device, Device{kBackend});
  EXPECT_FALSE(detector->device().name.empty());
  const std::vector<DeviceInfo> devices = list_devices();
  ASSERT_FALSE(devices.empty());
  EXPECT_EQ(devices[0].device, Device{});
  EXPECT_EQ(devices.size() > 1, cuda_available());
}

TEST(Kernels, AreLoadedAtTheStartUnlessTheEnvironmentSaysOtherwise) {
  const char* const kLoading = "CUDA_MODULE_LOADING";
  unsetenv(kLoading);
  load_kernels_at_start();
  EXPECT_STREQ(getenv(kLoading), "EAGER");
  setenv(kLoading, "LAZY", 1);
  load_kernels_at_start();
  EXPECT_STREQ(getenv(kLoading), "LAZY");
  unsetenv(kLoading);
}

}  // namespace
}  // namespace collided::test
