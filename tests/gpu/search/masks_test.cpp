// Meshes that may not touch each other: the scene finds what each finds alone, and costs what they cost alone.

#include <algorithm>
#include <set>

#include "gpu/tables/exclusions.hpp"
#include "tests/gpu/backend.hpp"
#include "tests/gpu/scene/sheets.hpp"

namespace collided::test {
namespace {

constexpr Engine kEngines[] = {Engine::kAuto,     Engine::kOctree,      Engine::kTopDown,
                               Engine::kBottomUp, Engine::kUniformGrid, Engine::kTwoLevelGrid,
                               Engine::kLbvh,     Engine::kVss,         Engine::kAllPairs};
constexpr uint32_t kSide = 4, kVertices = kSide * kSide, kTriangles = 2 * (kSide - 1) * (kSide - 1);

/// How probes are kept from each other.
enum class Kept { kByMasks, kByExclusions, kByExclusionsTouchingThemselves, kStatic };

bool is_by_exclusions(Kept kept) {
  return kept == Kept::kByExclusions || kept == Kept::kByExclusionsTouchingThemselves;
}

/// Sheet `probe` of many that lie in about the same place.
Positions probe_positions(uint32_t probe) { return shaken(flat_grid(kSide, 1), 100 + probe, 0.02); }

/// The probes from `first` on, and an obstacle that all of them cross, which is the last mesh.
Case probes_of(uint32_t first, uint32_t count, Kept kept) {
  Case c;
  for (uint32_t p = first; p < first + count; ++p) {
    add_mesh(c, grid_triangles(kSide), probe_positions(p), {}, kept == Kept::kStatic);
    MeshSpec& probe = c.meshes.back();
    if (kept == Kept::kByMasks) probe.groups = 2, probe.collide_mask = 1;
    probe.self_contacts = kept == Kept::kByExclusionsTouchingThemselves;
  }
  add_mesh(c, grid_triangles(kSide), grid(kSide, [](double i, double j) { return Vec3d{1.5 + 0.1 * i, j, i - 1.05}; }));
  c.meshes.back().self_contacts = false;
  return c;
}
SceneSpec spec_of(const Case& c, Kept kept, Engine engine) {
  SceneSpec spec = settings(Mode::kDcd, Accuracy::kCertified, Scalar::kF64, 0.125);
  spec.engine = engine;
  const auto obstacle = static_cast<uint32_t>(c.meshes.size()) - 1;
  if (is_by_exclusions(kept))
    for (uint32_t a = 0; a < obstacle; ++a)
      for (uint32_t b = a + 1; b < obstacle; ++b) spec.excluded_meshes.push_back({a, b});
  return spec;
}

using Elements = std::vector<std::array<uint32_t, 2>>;

/// Vertex-triangle contacts of each probe alone, with the ids of a scene of `count` of them.
Elements found_alone(uint32_t count, Kept kept) {
  Elements all;
  for (uint32_t p = 0; p < count; ++p) {
    const Case alone = probes_of(p, 1, kept);
    const auto moved = [&](uint32_t id, uint32_t of_mesh) {
      return id < of_mesh ? id + p * of_mesh : id + (count - 1) * of_mesh;
    };
    for (const auto& [vertex, triangle] :
         run_case(alone, spec_of(alone, kept, Engine::kAllPairs)).vertex_triangle.elements)
      all.push_back({moved(vertex, kVertices), moved(triangle, kTriangles)});
  }
  std::sort(all.begin(), all.end());
  return all;
}

class Masks : public OnBackend<::testing::TestWithParam<Kept>> {};

TEST_P(Masks, ASceneFindsWhatEachOfItsProbesFindsAlone) {
  constexpr uint32_t kProbes = 60;
  const Elements expected = found_alone(kProbes, GetParam());
  ASSERT_GT(expected.size(), kProbes);
  const Case all = probes_of(0, kProbes, GetParam());
  for (const Engine engine : kEngines) {
    const FrameResult result = run_case(all, spec_of(all, GetParam(), engine));
    const auto& elements = result.vertex_triangle.elements;
    EXPECT_EQ(Elements(elements.begin(), elements.end()), expected) << static_cast<int>(engine);
  }
}

// Each walk goes down to what its triangle may touch: the logarithm of the others' number.
TEST_P(Masks, TheHierarchyTestsWhatItsProbesTestAlone) {
  constexpr uint32_t kProbes = 250;
  if (is_by_exclusions(GetParam())) GTEST_SKIP() << "nodes of several meshes have no exclusions";
  const Case all = probes_of(0, kProbes, GetParam()), one = probes_of(0, 1, GetParam());
  const uint64_t tests = run_case(all, spec_of(all, GetParam(), Engine::kLbvh)).counts.tests,
                 alone = run_case(one, spec_of(one, GetParam(), Engine::kLbvh)).counts.tests;
  EXPECT_LT(tests, 4 * kProbes * alone);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Masks,
                         ::testing::Values(Kept::kByMasks, Kept::kByExclusions, Kept::kByExclusionsTouchingThemselves,
                                           Kept::kStatic));

std::vector<uint32_t> branches_of_meshes(const SceneSpec& spec) {
  std::vector<uint32_t> branches;
  for (const MeshRule& rule : mesh_rules(spec)) branches.push_back(rule.branch);
  return branches;
}
SceneSpec probes_spec(Kept kept, uint32_t count) {
  const Case c = probes_of(0, count, kept);
  return spec_for(c, spec_of(c, kept, Engine::kAuto));
}

TEST(Branches, AreOfMeshesThatMayTouchTheSame) {
  EXPECT_EQ(branches_of_meshes(probes_spec(Kept::kByMasks, 20)).back(), 1u);
  EXPECT_EQ(count_branches(probes_spec(Kept::kByMasks, 20)), 2u);
  EXPECT_EQ(count_branches(probes_spec(Kept::kStatic, 20)), 2u);
}

TEST(Branches, AreOfEachMeshThatExclusionsKeepFromItsLike) {
  for (const Kept kept : {Kept::kByExclusions, Kept::kByExclusionsTouchingThemselves}) {
    const SceneSpec spec = probes_spec(kept, 40);
    const auto branches = branches_of_meshes(spec);
    EXPECT_EQ(std::set(branches.begin(), branches.end()).size(), 41u);
    EXPECT_EQ(count_branches(spec), 41u);
  }
}

// A cloth and another mesh: what one of them may not touch would be met on every walk through its crowd.
TEST(Branches, AreFewWhereLittleOfAMeshIsKeptApart) {
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
  spec.meshes.resize(2);
  spec.meshes[0].vertex_count = 3000, spec.meshes[1].vertex_count = 1000;
  EXPECT_EQ(count_branches(spec), 0u);
  spec.meshes[1].self_contacts = false;
  EXPECT_EQ(branches_of_meshes(spec), (std::vector<uint32_t>{0, 1}));
  spec.meshes[1].vertex_count = 100;  // nothing to gain
  EXPECT_EQ(count_branches(spec), 0u);
  spec.meshes[1] = {.vertex_count = 1000, .collide_mask = 2};  // takes no part
  EXPECT_EQ(count_branches(spec), 0u);
}

std::vector<uint32_t> idle_in(const SceneSpec& spec) {
  std::vector<uint32_t> idle;
  for (uint32_t mesh = 0; mesh < spec.meshes.size(); ++mesh)
    if (idle_meshes(spec).has(mesh)) idle.push_back(mesh);
  return idle;
}

TEST(IdleMeshes, AreThoseThatNoOtherMeshMayTouchNorThemselves) {
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
  spec.meshes.resize(4);
  for (MeshSpec& mesh : spec.meshes) mesh.vertex_count = 3;
  EXPECT_FALSE(idle_meshes(spec).has_any());
  spec.meshes[1].groups = 2;
  EXPECT_EQ(idle_in(spec), (std::vector<uint32_t>{}));
  spec.meshes[1].collide_mask = 4;
  EXPECT_EQ(idle_in(spec), (std::vector<uint32_t>{1}));
  spec.meshes[2].self_contacts = false;
  EXPECT_EQ(idle_in(spec), (std::vector<uint32_t>{1}));
  spec.excluded_meshes = {{2, 0}, {3, 2}};
  EXPECT_EQ(idle_in(spec), (std::vector<uint32_t>{1, 2}));
  spec.excluded_meshes.push_back({3, 3});
  EXPECT_EQ(idle_in(spec), (std::vector<uint32_t>{1, 2}));
  EXPECT_FALSE(idle_meshes(spec).are_all);
  spec.meshes[0].motion = spec.meshes[3].motion = MeshMotion::kStatic;
  EXPECT_EQ(idle_in(spec), (std::vector<uint32_t>{0, 1, 2, 3}));
  EXPECT_TRUE(idle_meshes(spec).are_all);
}

TEST(Branches, AreNoneWhereMostMeshesMayTouch) {
  SceneSpec spec = probes_spec(Kept::kByMasks, 20);
  for (MeshSpec& mesh : spec.meshes) mesh.groups = 1, mesh.collide_mask = ~0u;
  EXPECT_EQ(count_branches(spec), 0u);
  spec.meshes[0].motion = MeshMotion::kStatic;
  EXPECT_EQ(count_branches(spec), 0u);
  spec.meshes.clear();
  EXPECT_EQ(count_branches(spec), 0u);
}

}  // namespace
}  // namespace collided::test
