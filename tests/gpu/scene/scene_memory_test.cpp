// The memory of a scene grows with what is in it, from very little on.

#include <cmath>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/every_field.hpp"

namespace collided::test {
namespace {

constexpr Accuracy kLevels[] = {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified,
                                Accuracy::kExact};

std::string text(const std::vector<MemoryPart>& parts) {
  std::string all;
  for (const MemoryPart& part : parts) all += part.part + " " + std::to_string(part.bytes) + ", ";
  return all;
}

uint64_t bytes_of(const std::vector<MemoryPart>& parts) {
  uint64_t bytes = 0;
  for (const MemoryPart& part : parts) bytes += part.bytes;
  return bytes;
}

/// What a scene holds after its first frame.
std::vector<MemoryPart> memory_of(const Case& c, const SceneSpec& settings) {
  const auto detector = Detector::create(spec_for(c, settings));
  detector->detect(Frame(c, settings.mode, settings.scalar).input());
  return detector->memory();
}

/// Separate triangles as large as those of a surface of so many.
Case triangles(uint32_t count) { return soup(80, count, 1, 1 / std::sqrt(count), 0.01); }

using SceneMemory = OnBackend<>;

TEST_F(SceneMemory, TwoTrianglesTakeLittle) {
  constexpr uint64_t kLimit = 64 << 10;
  for (const Mode mode : {Mode::kDcd, Mode::kCcd})
    for (const Accuracy level : kLevels)
      for (const Engine engine : {Engine::kOctree, Engine::kTwoLevelGrid, Engine::kLbvh, Engine::kVss,
                                  Engine::kAllPairs}) {
        SceneSpec spec = settings(mode, level, Scalar::kF64, 0.01);
        spec.engine = engine;
        spec.fields = kEveryField;
        spec.kinds.triangle_triangle = mode == Mode::kDcd;
        const auto parts = memory_of(triangles(2), spec);
        EXPECT_LE(bytes_of(parts), kLimit) << text(parts);
      }
}

TEST_F(SceneMemory, GrowsWithTheTriangles) {
  constexpr uint64_t kOfTriangle = 2048, kFirstLists = 320 << 10;
  for (const uint32_t count : {2u, 30u, 100u, 1'000u, 10'000u}) {
    const auto parts = memory_of(triangles(count), settings(Mode::kCcd, Accuracy::kCertified));
    EXPECT_LE(bytes_of(parts), kFirstLists + count * kOfTriangle) << count << " triangles: " << text(parts);
  }
}

// A scene of few dense levels finds what it always did, also where its triangles are crowded in a part of it.
TEST_F(SceneMemory, FewDenseLevelsFindTheSame) {
  for (const uint32_t count : {2u, 31u, 32u, 300u}) {
    Case c = soup(81, count, 1, 0.3, 0.1);
    const Case far = soup(82, 1, 1, 0.3, 0.1, {1e4, 1e4, 1e4});
    add_mesh(c, far.meshes[0].triangles, far.start[0], far.end[0]);
    SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
    spec.engine = Engine::kLbvh;
    const FrameResult expected = run_case(c, spec);
    for (const Engine engine : {Engine::kOctree, Engine::kUniformGrid, Engine::kTwoLevelGrid, Engine::kVss,
                                Engine::kAllPairs}) {
      spec.engine = engine;
      EXPECT_TRUE(same_contacts(run_case(c, spec), expected)) << count << " triangles";
    }
  }
}

}  // namespace
}  // namespace collided::test
