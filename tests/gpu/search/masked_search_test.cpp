// What masks keep apart costs no search: meshes that may touch nothing take no part, and those that move far without
// touching themselves are passed over. What is found is what brute force finds.

#include <algorithm>
#include <random>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/scene/sheets.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/brute_force.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/every_field.hpp"
#include "tests/support/exclusions.hpp"

namespace collided::test {
namespace {

constexpr Engine kEngines[] = {Engine::kAuto,        Engine::kOctree,       Engine::kTopDown,
                               Engine::kUniformGrid, Engine::kTwoLevelGrid, Engine::kLbvh,
                               Engine::kVss,         Engine::kAllPairs};

class MaskedSearch : public OnBackend<> {};

struct Masked {
  Case scene;
  std::vector<std::array<uint32_t, 2>> excluded;
};

/// Seven sheets in about one place. About one in three may touch nothing.
Masked random_masks(uint32_t seed) {
  std::mt19937 random(seed);
  const auto one_of = [&](uint32_t count) { return static_cast<uint32_t>(random() % count); };
  Masked masked;
  Case& c = masked.scene;
  for (uint32_t m = 0; m < 7; ++m) {
    const bool is_static = one_of(5) == 0;
    const Positions start = shaken(flat_grid(5, 1), 100 * seed + m, 0.4);
    add_mesh(c, grid_triangles(5), start, is_static ? start : shaken(start, 100 * seed + m + 50, 0.6), is_static);
    MeshSpec& mesh = c.meshes.back();
    mesh.groups = 1u << one_of(3);
    mesh.collide_mask = one_of(3) == 0 ? 0 : one_of(8);
    mesh.self_contacts = one_of(2) == 0;
  }
  for (uint32_t a = 0; a < 7; ++a)
    for (uint32_t b = a; b < 7; ++b)
      if (one_of(6) == 0) masked.excluded.push_back({b, a});
  return masked;
}

TEST_F(MaskedSearch, FindsWhatBruteForceFinds) {
  size_t found = 0;
  for (uint32_t seed = 0; seed < 12; ++seed) {
    const Masked masked = random_masks(seed);
    for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
      SceneSpec wanted = settings(mode, Accuracy::kCandidates);
      wanted.excluded_meshes = masked.excluded;
      const Exclusions excluded(masked.scene, spec_for(masked.scene, wanted));
      const ExpectedPairs all = brute_force(masked.scene, mode, Scalar::kF64, 0);
      const PairSet first = excluded.left_of(ContactKind::kVertexTriangle, all.vertex_triangle),
                    second = excluded.left_of(ContactKind::kEdgeEdge, all.edge_edge);
      for (const Engine engine : kEngines) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", engine " + std::to_string(static_cast<int>(engine)));
        wanted.engine = engine;
        const FrameResult result = run_case(masked.scene, wanted);
        EXPECT_EQ(compare(result.vertex_triangle.elements, first), "");
        EXPECT_EQ(compare(result.edge_edge.elements, second), "");
        found += first.must.size() + second.must.size();
      }
    }
  }
  EXPECT_GT(found, 100'000u);
}

// Bit for bit, over frames in which static meshes are boxed once and lists come and go.
TEST_F(MaskedSearch, FindsTheContactsThatTheSceneHasWithoutMasks) {
  for (uint32_t seed = 20; seed < 23; ++seed)
    for (const Engine engine : {Engine::kAuto, Engine::kOctree, Engine::kLbvh}) {
      const Masked masked = random_masks(seed);
      SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32, 0.03);
      spec.engine = engine;
      spec.fields = kEveryField;
      spec.reuse = engine == Engine::kLbvh ? Reuse::kOn : Reuse::kAuto;
      spec.excluded_meshes = masked.excluded;
      spec = spec_for(masked.scene, spec);
      const Case c = rounded(masked.scene, Scalar::kF32);
      const Exclusions excluded(c, spec);
      const auto scene = Detector::create(spec), full = Detector::create(full_model(spec));
      for (int frame = 0; frame < 4; ++frame) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", frame " + std::to_string(frame));
        const Frame positions(c, Mode::kCcd, Scalar::kF32, frame == 0);
        const FrameResult left = scene->detect(positions.input()), all = full->detect(positions.input());
        for_each_kind(
            [&](ContactKind kind, const ContactSet& found, const ContactSet& of_all) {
              EXPECT_TRUE(same_bytes(excluded.left_of(kind, of_all), found));
            },
            left, all);
      }
    }
}

/// A sheet of n x n vertices and width 1 that moves far: the boxes of all its triangles overlap.
void add_far_mover(Case& c, uint32_t n, const Vec3d& at) {
  const auto sheet = [&](double by) {
    return grid(n, [&](double i, double j) { return Vec3d{at[0] + i / n + by, at[1] + j / n + by, at[2] + by}; });
  };
  add_mesh(c, grid_triangles(n), sheet(0), sheet(0.5));
  c.meshes.back().self_contacts = false;
}
FrameResult run_with(const Case& c, Engine engine) {
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32);
  spec.engine = engine;
  return run_case(c, spec);
}
bool has_stage(const FrameResult& result, const std::string& name) {
  return std::any_of(result.stages.begin(), result.stages.end(), [&](const auto& s) { return s.stage == name; });
}

TEST_F(MaskedSearch, IsNoneWhereNothingMayTouch) {
  Case c;
  add_far_mover(c, 50, {});
  add_far_mover(c, 20, {});
  c.meshes[1].collide_mask = 0;
  for (const Engine engine : kEngines) {
    const FrameResult result = run_with(c, engine);
    EXPECT_EQ(result.counts.tests + result.counts.registrations, 0u) << static_cast<int>(engine);
    for (const char* stage : {"count", "refine", "sort", "hierarchy", "pairs"}) EXPECT_FALSE(has_stage(result, stage));
  }
}

TEST_F(MaskedSearch, CostsNothingForMeshesThatMayTouchNothing) {
  Case alone;
  add_mesh(alone, grid_triangles(40), flat_grid(40, 0.04));
  Case all = alone;
  for (int k = 0; k < 8; ++k) add_far_mover(all, 20, {0.1, 0.1, -0.25}), all.meshes.back().collide_mask = 0;
  for (const Engine engine : {Engine::kOctree, Engine::kLbvh}) {
    const uint64_t tests = run_with(all, engine).counts.tests, own = run_with(alone, engine).counts.tests;
    EXPECT_LT(tests, 4 * own) << static_cast<int>(engine);
  }
}

// 2 x 3,042 triangles, some of which may touch: the octree would make tests for each pair of those that move far.
TEST_F(MaskedSearch, PassesOverWhatMovesFarBesideACloth) {
  Case c;
  add_mesh(c, grid_triangles(40), flat_grid(40, 0.025), shaken(flat_grid(40, 0.025), 1, 0.001));
  add_far_mover(c, 40, {2, 2, 2});
  const FrameResult result = run_with(c, Engine::kAuto);
  EXPECT_EQ(result.broad_phase.engine, Engine::kLbvh);
  EXPECT_LT(result.counts.tests, 100 * 2 * 3042u);
}

// Its jumps would end lists that others are served by.
TEST_F(MaskedSearch, KeepsItsListsWhateverAMeshDoesThatMayTouchNothing) {
  Case c;
  add_mesh(c, grid_triangles(12), flat_grid(12, 1), shaken(flat_grid(12, 1), 3, 0.01));
  add_mesh(c, grid_triangles(12), shaken(flat_grid(12, 1), 4, 0.01));
  add_far_mover(c, 12, {0, 0, 3});
  c.meshes.back().collide_mask = 0;
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
  spec.reuse = Reuse::kOn;
  const auto scene = Detector::create(spec_for(c, spec));
  uint32_t reused = 0;
  for (uint32_t frame = 0; frame < 24; ++frame) {
    c.end[2] = shaken(flat_grid(12, 1), 10 + frame, 0.45);
    const FrameResult result = scene->detect(Frame(c, Mode::kCcd, Scalar::kF64).input());
    reused += result.reuse.use == ListUse::kReused ? 1 : 0;
    for (uint32_t mesh = 0; mesh < 3; ++mesh) c.start[mesh] = c.end[mesh];
  }
  EXPECT_GE(reused, 12u);
}

}  // namespace
}  // namespace collided::test
