// Scenes that are edited between frames answer as if they had been made so: as brute force, the exact judge and a new
// scene of the same meshes and positions do.

#include <gtest/gtest.h>

#include "tests/gpu/counted_quota.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/gpu/scene/living_scene.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/exclusions.hpp"

namespace collided::test {
namespace {

struct Kind {
  Mode mode;
  Scalar scalar;
};
void PrintTo(const Kind& kind, std::ostream* out) {
  *out << (kind.mode == Mode::kCcd ? "Ccd" : "Dcd") << (kind.scalar == Scalar::kF32 ? "F32" : "F64");
}

class RandomEdits : public OnBackend<::testing::TestWithParam<Kind>> {
 protected:
  static void expect_brute_force(const LivingScene& scene, const FrameResult& found) {
    const Case& c = scene.now();
    const ExpectedPairs all = brute_force(c, scene.spec().mode, scene.spec().scalar, scene.spec().thickness);
    const Exclusions excluded(scene.rest(), scene.spec());
    EXPECT_EQ("", compare(found.vertex_triangle.elements,
                          excluded.left_of(ContactKind::kVertexTriangle, all.vertex_triangle)));
    EXPECT_EQ("", compare(found.edge_edge.elements, excluded.left_of(ContactKind::kEdgeEdge, all.edge_edge)));
  }

  /// The judge's contacts of the pairs whose boxes overlap and that are not left out.
  static void expect_truth(const LivingScene& scene, const FrameResult& found) {
    const SceneSpec& spec = scene.spec();
    const ExpectedPairs all = brute_force(scene.now(), spec.mode, spec.scalar, spec.thickness);
    const Exclusions excluded(scene.rest(), spec);
    const CaseJudge judge(scene.now(), spec.mode, spec.thickness);
    const auto pairs = [&](ContactKind kind, const PairSet& of_kind) {
      std::vector<std::array<uint32_t, 2>> out;
      for (const PairKey key : excluded.left_of(kind, of_kind).may)
        out.push_back({static_cast<uint32_t>(key >> 32), static_cast<uint32_t>(key)});
      return out;
    };
    EXPECT_EQ(keys_of(found.vertex_triangle),
              keys_of(judge.vertex_triangle(pairs(ContactKind::kVertexTriangle, all.vertex_triangle))));
    EXPECT_EQ(keys_of(found.edge_edge), keys_of(judge.edge_edge(pairs(ContactKind::kEdgeEdge, all.edge_edge))));
  }
};

// A quarter of a thousand for each mode and scalar. Frames without an edit come between them; some edits are refused and
// some of their frames given up, and leave no trace.
TEST_P(RandomEdits, LeaveNoWrongAndNoStaleContact) {
  constexpr int kEdits = 250;
  LivingScene scene(GetParam().mode, GetParam().scalar, 7);
  const auto detector = Detector::create(scene.spec());
  detector->detect(scene.first_frame().input());
  size_t contacts = 0;
  for (int i = 0, edits = 0; edits < kEdits && !HasFailure(); ++i) {
    SCOPED_TRACE("frame " + std::to_string(i));
    if (i % 5 == 0) scene.try_in_vain(*detector);
    const OwnedFrame frame = i % 4 == 3 ? scene.next_frame() : scene.next_edit();
    FrameInput input = frame.input();
    input.accuracy = i % 2 == 0 ? Accuracy::kCandidates : Accuracy::kExact;
    const FrameResult found = detector->detect(input);
    scene.applied(frame);
    EXPECT_EQ(detector->topology().vertex_offset.back(), scene.vertex_count());
    input.accuracy == Accuracy::kExact ? expect_truth(scene, found) : expect_brute_force(scene, found);
    contacts += count_contacts(found);
    edits += frame.edit ? 1 : 0;
  }
  EXPECT_GT(contacts, kEdits * 10u);
  EXPECT_GT(scene.meshes_added(), 10u);
  EXPECT_GT(scene.meshes_removed(), 10u);
  EXPECT_GT(scene.tears(), 10u);
}

INSTANTIATE_TEST_SUITE_P(Kinds, RandomEdits,
                         ::testing::Values(Kind{Mode::kDcd, Scalar::kF32}, Kind{Mode::kDcd, Scalar::kF64},
                                           Kind{Mode::kCcd, Scalar::kF32}, Kind{Mode::kCcd, Scalar::kF64}),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace collided::test
