// Bad specs of what is left out, and tables too large to hold.

#include <cmath>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/counted_quota.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/gpu/scene/sheets.hpp"

namespace collided::test {
namespace {

SceneSpec valid_spec() {
  Case c;
  for (int m = 0; m < 3; ++m) add_mesh(c, grid_triangles(4), flat_grid(4, 1));
  return spec_for(c, settings(Mode::kDcd, Accuracy::kCertified, Scalar::kF64, 0.1));
}

std::string refused_with(const std::function<void(SceneSpec&)>& change) {
  SceneSpec spec = valid_spec();
  change(spec);
  return refused_field([&] { Detector::create(spec); });
}

using ExclusionSpecs = OnBackend<>;

TEST_F(ExclusionSpecs, ValidOnesAreTaken) {
  EXPECT_EQ("", refused_with([](SceneSpec& s) {
              s.meshes[1].excluded_rings = kMaxRings;
              s.meshes[2].excludes_rest_pairs = true;
              s.rest_distance = 0.1;
              s.excluded_meshes = {{0, 1}, {2, 2}, {2, 1}};
            }));
}

TEST_F(ExclusionSpecs, RingsHaveALimit) {
  for (const uint32_t rings : {kMaxRings + 1, ~0u})
    EXPECT_EQ("meshes[1].excluded_rings", refused_with([&](SceneSpec& s) { s.meshes[1].excluded_rings = rings; }));
}

TEST_F(ExclusionSpecs, ExcludedMeshesAreOfTheSceneAndNamedOnce) {
  EXPECT_EQ("excluded_meshes[1]", refused_with([](SceneSpec& s) { s.excluded_meshes = {{0, 1}, {1, 3}}; }));
  EXPECT_EQ("excluded_meshes[0]", refused_with([](SceneSpec& s) { s.excluded_meshes = {{~0u, 0}}; }));
  EXPECT_EQ("excluded_meshes[2]", refused_with([](SceneSpec& s) { s.excluded_meshes = {{0, 1}, {1, 2}, {1, 0}}; }));
  EXPECT_EQ("excluded_meshes[1]", refused_with([](SceneSpec& s) { s.excluded_meshes = {{1, 1}, {1, 1}}; }));
}

TEST_F(ExclusionSpecs, RestDistanceIsALengthThatSomeMeshUses) {
  for (const double bad : {-1.0, -1e-300, HUGE_VAL, std::nan("")})
    EXPECT_EQ("rest_distance", refused_with([&](SceneSpec& s) {
                s.meshes[0].excludes_rest_pairs = true;
                s.rest_distance = bad;
              }))
        << bad;
  EXPECT_EQ("rest_distance", refused_with([](SceneSpec& s) { s.rest_distance = 0.1; }));
}

TEST_F(ExclusionSpecs, RestPairsAreOfFeatures) {
  EXPECT_EQ("meshes[2].excludes_rest_pairs", refused_with([](SceneSpec& s) {
              s.meshes[2].excludes_rest_pairs = true;
              s.kinds = {.triangle_triangle = true};
            }));
}

// A wheel: every vertex is within two edges of every other, so that rings take the square of its size.
SceneSpec wheel(uint32_t spokes) {
  Case c;
  Positions positions{{0, 0, 0}};
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 0; i < spokes; ++i) {
    positions.push_back({std::cos(2 * std::numbers::pi * i / spokes), std::sin(2 * std::numbers::pi * i / spokes), 0});
    triangles.push_back({0, i + 1, (i + 1) % spokes + 1});
  }
  add_mesh(c, triangles, positions);
  SceneSpec spec = spec_for(c, settings(Mode::kDcd, Accuracy::kCertified));
  spec.meshes[0].excluded_rings = 2;
  return spec;
}

TEST_F(ExclusionSpecs, RingsTooLargeForTheBudgetAreRefused) {
  SceneSpec spec = wheel(3000);
  const auto quota = std::make_shared<CountedQuota>();
  spec.memory_quota = quota;
  spec.memory_budget = 20u << 20;
  EXPECT_THROW(Detector::create(spec), ResourceExhausted);
  EXPECT_EQ(quota->held(), 0u);
  EXPECT_LT(quota->peak(), spec.memory_budget + (8u << 20));
}

TEST_F(ExclusionSpecs, RingsAreTakenFromTheQuotaBeforeTheyAreHeld) {
  SceneSpec spec = wheel(1000);
  const auto quota = std::make_shared<CountedQuota>();
  spec.memory_quota = quota;
  {
    const auto detector = Detector::create(spec);
    uint64_t rings = 0;
    for (const MemoryPart& part : detector->memory()) rings += part.part == "rings" ? part.bytes : 0;
    EXPECT_EQ(rings, sizeof(uint32_t) * (1001 * 1000 + 1002));
    EXPECT_GE(quota->peak(), 2 * rings);  // while they are on the host, too
    EXPECT_GE(quota->held(), rings);
  }
  EXPECT_EQ(quota->held(), 0u);
  const auto small = std::make_shared<CountedQuota>(quota->peak() / 2);
  spec.memory_quota = small;
  EXPECT_THROW(Detector::create(spec), ResourceExhausted);
  EXPECT_EQ(small->held(), 0u);
}

}  // namespace
}  // namespace collided::test
