// What a spec leaves out: a scene's contacts are those of the full model without it, byte for byte.

#include "tests/support/exclusions.hpp"

#include <algorithm>
#include <set>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/scene/sheets.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/every_field.hpp"

namespace collided::test {
namespace {

constexpr Engine kEngines[] = {Engine::kOctree,       Engine::kTopDown, Engine::kBottomUp, Engine::kUniformGrid,
                               Engine::kTwoLevelGrid, Engine::kLbvh,    Engine::kVss,
                              Engine::kAllPairs};
constexpr Accuracy kLevels[] = {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified,
                                Accuracy::kExact};

/// One switch of a spec, or several.
struct Switch {
  std::string name;
  void (*turn_on)(SceneSpec&);
};
void PrintTo(const Switch& s, std::ostream* out) { *out << s.name; }

void exclude_groups(SceneSpec& spec) {
  spec.meshes[0].groups = 3;
  spec.meshes[1].groups = 2, spec.meshes[1].collide_mask = 1;
  spec.meshes[2].groups = 4, spec.meshes[2].collide_mask = ~2u;
}
void leave_meshes_to_others(SceneSpec& spec) {
  for (MeshSpec& mesh : spec.meshes) mesh.self_contacts = false;
}
void exclude_meshes(SceneSpec& spec) { spec.excluded_meshes = {{2, 0}, {1, 1}, {1, 3}}; }
void exclude_rings(SceneSpec& spec) {
  for (uint32_t m = 0; m < 3; ++m) spec.meshes[m].excluded_rings = 2 * m;
}
void exclude_rest_pairs(SceneSpec& spec) {
  spec.meshes[0].excludes_rest_pairs = spec.meshes[2].excludes_rest_pairs = true;
  spec.rest_distance = 0.75;
}
void exclude_all(SceneSpec& spec) {
  exclude_groups(spec);
  spec.excluded_meshes = {{2, 0}};
  exclude_rings(spec);
  exclude_rest_pairs(spec);
}

const Switch kSwitches[] = {{"Groups", exclude_groups},        {"NoSelfContacts", leave_meshes_to_others},
                            {"Meshes", exclude_meshes},        {"Rings", exclude_rings},
                            {"RestPairs", exclude_rest_pairs}, {"All", exclude_all}};

std::vector<FrameResult> run(const SceneSpec& spec, const std::vector<Case>& frames) {
  const auto detector = Detector::create(spec);
  std::vector<FrameResult> results;
  for (size_t i = 0; i < frames.size(); ++i)
    results.push_back(detector->detect(Frame(frames[i], spec.mode, spec.scalar, i == 0).input()));
  return results;
}

class LeftOut : public OnBackend<::testing::TestWithParam<std::tuple<Switch, bool>>> {
 protected:
  static bool is_loose() { return std::get<1>(GetParam()); }
  static std::vector<Case> rounded_frames(Scalar scalar) {
    return folded_sheets([&](Case c) { return rounded(is_loose() ? loosened(std::move(c)) : std::move(c), scalar); });
  }

  SceneSpec spec_with(const std::vector<Case>& frames, SceneSpec settings) const {
    SceneSpec spec = spec_for(frames[0], std::move(settings));
    spec.fields = kEveryField.without(ContactField::kFeatures);  // a contact that is left out covers none
    std::get<0>(GetParam()).turn_on(spec);
    return spec;
  }

  /// Returns how many contacts were left out.
  size_t expect_restricted(const SceneSpec& spec, const std::vector<Case>& frames) const {
    const Exclusions excluded(frames[0], spec);
    const std::vector<FrameResult> full = run(full_model(spec), frames), left = run(spec, frames);
    size_t count = 0;
    for (size_t f = 0; f < frames.size(); ++f) {
      SCOPED_TRACE("frame " + std::to_string(f));
      for_each_kind(
          [&](ContactKind kind, const ContactSet& all, const ContactSet& found) {
            const ContactSet expected = excluded.left_of(kind, all);
            EXPECT_TRUE(same_bytes(expected, found)) << found.size() << " contacts of " << expected.size();
            count += all.size() - found.size();
          },
          full[f], left[f]);
    }
    return count;
  }
};

TEST_P(LeftOut, AtEveryLevelInBothModesAndScalars) {
  for (const Scalar scalar : {Scalar::kF32, Scalar::kF64}) {
    const std::vector<Case> frames = rounded_frames(scalar);
    for (const Mode mode : {Mode::kDcd, Mode::kCcd})
      for (const Accuracy accuracy : kLevels) {
        SCOPED_TRACE(level_name(accuracy) + (mode == Mode::kCcd ? " CCD" : " DCD"));
        SceneSpec wanted = settings(mode, accuracy, scalar, 0.5);
        wanted.kinds.triangle_triangle = mode == Mode::kDcd;
        EXPECT_GT(expect_restricted(spec_with(frames, wanted), frames), 0u);
      }
  }
}

TEST_P(LeftOut, OfOneKindAlone) {
  const std::vector<Case> frames = rounded_frames(Scalar::kF64);
  for (const bool vertex_triangle : {false, true}) {
    SceneSpec wanted = settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF64, 0.5);
    (vertex_triangle ? wanted.kinds.edge_edge : wanted.kinds.vertex_triangle) = false;
    EXPECT_GT(expect_restricted(spec_with(frames, wanted), frames), 0u);
  }
}

TEST_P(LeftOut, ByEveryEngineAndAnyNumberOfThreads) {
  const std::vector<Case> frames = rounded_frames(Scalar::kF32);
  for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
    SceneSpec spec = spec_with(frames, settings(mode, Accuracy::kGuarded, Scalar::kF32, 0.5));
    spec.engine = Engine::kOctree;
    const std::vector<FrameResult> octree = run(spec, frames);
    for (const Engine engine : kEngines)
      for (const int threads : {1, 2}) {
        SCOPED_TRACE("engine " + std::to_string(static_cast<int>(engine)));
        spec.engine = engine;
        spec.threads = threads;
        const std::vector<FrameResult> found = run(spec, frames);
        for (size_t f = 0; f < frames.size(); ++f) EXPECT_TRUE(same_contacts(octree[f], found[f]));
      }
  }
}

// Boxes that overlap, found without the engine; what is left out is no candidate, in the list and in the counts.
TEST_P(LeftOut, OfTheCandidates) {
  const std::vector<Case> frames = rounded_frames(Scalar::kF32);
  for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
    const SceneSpec spec = spec_with(frames, settings(mode, Accuracy::kCandidates, Scalar::kF32, 0.5));
    const Exclusions excluded(frames[0], spec);
    const std::vector<FrameResult> found = run(spec, frames);
    for (size_t f = 0; f < frames.size(); ++f) {
      const ExpectedPairs all = brute_force(frames[f], mode, Scalar::kF32, spec.thickness);
      const FrameResult& r = found[f];
      EXPECT_EQ(
          "", compare(r.vertex_triangle.elements, excluded.left_of(ContactKind::kVertexTriangle, all.vertex_triangle)));
      EXPECT_EQ("", compare(r.edge_edge.elements, excluded.left_of(ContactKind::kEdgeEdge, all.edge_edge)));
      EXPECT_EQ(r.counts.candidates.vertex_triangle, r.vertex_triangle.size());
      EXPECT_EQ(r.counts.candidates.edge_edge, r.edge_edge.size());
    }
  }
}

TEST_P(LeftOut, OfTheReportsOfOneContact) {
  const std::vector<Case> frames = rounded_frames(Scalar::kF64);
  for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact}) {
    SceneSpec spec = spec_with(frames, settings(Mode::kCcd, accuracy));
    const std::vector<FrameResult> all = run(spec, frames);
    spec.report = Report::kEarliestOnly;
    const std::vector<FrameResult> earliest = run(spec, frames);
    spec.report = Report::kAnyHit;
    const std::vector<FrameResult> any = run(spec, frames);
    for (size_t f = 0; f < frames.size(); ++f) {
      double first = 1;
      for (const ContactSet* set : {&all[f].vertex_triangle, &all[f].edge_edge})
        for (const double toi : set->toi) first = std::min(first, toi);
      EXPECT_EQ(all[f].earliest_toi, first);
      EXPECT_EQ(earliest[f].earliest_toi, first);
      EXPECT_EQ(earliest[f].any_contact, count_contacts(all[f]) > 0);
      EXPECT_EQ(any[f].any_contact, count_contacts(all[f]) > 0);
    }
  }
}

// A scene has the tables that its switches need, and no other.
TEST_P(LeftOut, NeedsItsOwnTablesAlone) {
  const std::vector<Case> frames = rounded_frames(Scalar::kF32);
  const SceneSpec spec = spec_with(frames, settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32, 0.5));
  const auto detector = Detector::create(spec);
  const FrameResult first = detector->detect(Frame(frames[0], spec.mode, spec.scalar).input());
  const FrameResult second = detector->detect(Frame(frames[1], spec.mode, spec.scalar, false).input());
  std::set<std::string> parts;
  for (const MemoryPart& part : detector->memory()) parts.insert(part.part);
  const std::string name = std::get<0>(GetParam()).name;
  const bool has_rings = name == "Rings" || name == "All", has_rest = name == "RestPairs" || name == "All";
  EXPECT_EQ(parts.contains("rings"), has_rings);
  EXPECT_EQ(parts.contains("rest_pairs"), has_rest);
  const auto has_stage = [](const FrameResult& r) {
    return std::any_of(r.stages.begin(), r.stages.end(), [](const auto& s) { return s.stage == "rest_pairs"; });
  };
  EXPECT_EQ(has_stage(first), has_rest);
  EXPECT_FALSE(has_stage(second));
}

INSTANTIATE_TEST_SUITE_P(Switches, LeftOut,
                         ::testing::Combine(::testing::ValuesIn(kSwitches), ::testing::Values(false, true)),
                         [](const auto& info) {
                           return std::get<0>(info.param).name + (std::get<1>(info.param) ? "Loose" : "");
                         });

using Exclusion = OnBackend<>;

uint64_t bytes_of(const Detector& detector, const char* name) {
  for (const MemoryPart& part : detector.memory())
    if (part.part == name) return part.bytes;
  return 0;
}

TEST_F(Exclusion, NothingIsHeldWhereNothingIsLeftOut) {
  Case c;
  add_mesh(c, grid_triangles(8), flat_grid(8, 1));
  const auto detector = Detector::create(spec_for(c, settings(Mode::kCcd, Accuracy::kCertified)));
  detector->detect(Frame(c, Mode::kCcd, Scalar::kF64).input());
  for (const char* part : {"rings", "rest_pairs", "pair_filter"}) EXPECT_EQ(bytes_of(*detector, part), 0u) << part;
}

// Only vertices of meshes with rings have entries, and a mesh that cannot touch itself needs none.
TEST_F(Exclusion, RingsHoldWhatTheyNeed) {
  constexpr uint64_t kVertex = sizeof(uint32_t);
  Case c;
  for (int m = 0; m < 2; ++m) add_mesh(c, grid_triangles(5), flat_grid(5, 1));
  SceneSpec spec = spec_for(c, settings(Mode::kDcd, Accuracy::kCertified));
  spec.meshes[1].excluded_rings = 1;
  // 20 + 20 + 16 edges, each of which puts either end into the other's ring.
  EXPECT_EQ(bytes_of(*Detector::create(spec), "rings"), (2 * 56 + 51) * kVertex);
  spec.meshes[1].self_contacts = false;
  EXPECT_EQ(bytes_of(*Detector::create(spec), "rings"), 0u);
}

// Bodies on a chain of joints: thousands of pairs, each looked up.
TEST_F(Exclusion, ChainOfManyBodies) {
  constexpr uint32_t kBodies = 1500;
  Case c;
  std::vector<std::array<uint32_t, 2>> joints;
  for (uint32_t m = 0; m < kBodies; ++m) {
    const double x = 0.6 * m;
    add_mesh(c, {{0, 1, 2}}, {{x, 0, 0}, {x + 1, 0.1, 0}, {x, 0, 1}});
    if (m > 0) joints.push_back({m, m - 1});
  }
  SceneSpec spec = spec_for(c, settings(Mode::kDcd, Accuracy::kCandidates, Scalar::kF32, 0.5));
  const Frame frame(c, spec.mode, spec.scalar);
  const FrameResult full = Detector::create(spec)->detect(frame.input());
  spec.excluded_meshes = joints;
  const FrameResult found = Detector::create(spec)->detect(frame.input());
  // The mesh of a feature follows from its number: a body has three vertices, three edges and one triangle.
  const auto expect_left = [](const ContactSet& all, const ContactSet& left, uint32_t of_second) {
    std::vector<std::array<uint32_t, 2>> expected;
    for (const auto& e : all.elements)
      if (const uint32_t m = e[0] / 3, n = e[1] / of_second; std::max(m, n) - std::min(m, n) > 1) expected.push_back(e);
    EXPECT_LT(expected.size(), all.size());
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), left.elements.begin(), left.elements.end()));
  };
  expect_left(full.vertex_triangle, found.vertex_triangle, 1);
  expect_left(full.edge_edge, found.edge_edge, 3);
  EXPECT_EQ(full.counts.pairs, 2 * kBodies - 3);
  EXPECT_EQ(found.counts.pairs, kBodies - 2);
}

}  // namespace
}  // namespace collided::test
