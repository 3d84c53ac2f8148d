// Bad input is refused with the path of the field, and harms nothing.

#include <cmath>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

Case small_case() {
  Case c = soup(50, 200, 1, 0.2, 0.05);
  const Case wall = soup(51, 50, 1, 0.3, 0);
  add_mesh(c, wall.meshes[0].triangles, wall.start[0], {}, true);
  return c;
}

SceneSpec valid_spec() { return spec_for(small_case(), settings(Mode::kCcd, Accuracy::kFast, Scalar::kF32)); }

using SpecValidation = OnBackend<>;

TEST_F(SpecValidation, ValidSpecIsTaken) { EXPECT_NO_THROW(Detector::create(valid_spec())); }

TEST_F(SpecValidation, ThicknessIsFiniteAndNotNegative) {
  for (double bad : {-1.0, -1e-300, HUGE_VAL, -HUGE_VAL, std::nan("")}) {
    SceneSpec spec = valid_spec();
    spec.thickness = bad;
    EXPECT_EQ("thickness", refused_field([&] { Detector::create(spec); })) << bad;
  }
}

TEST_F(SpecValidation, DiscreteContactsNeedADistance) {
  SceneSpec spec = valid_spec();
  spec.mode = Mode::kDcd;
  EXPECT_EQ("thickness", refused_field([&] { Detector::create(spec); }));
  spec.accuracy = Accuracy::kCandidates;
  EXPECT_NO_THROW(Detector::create(spec));
}

TEST_F(SpecValidation, SomeKindIsWanted) {
  SceneSpec spec = valid_spec();
  spec.kinds.vertex_triangle = spec.kinds.edge_edge = false;
  EXPECT_EQ("kinds", refused_field([&] { Detector::create(spec); }));
}

TEST_F(SpecValidation, SomeMeshIsNeeded) {
  SceneSpec spec = valid_spec();
  spec.meshes.clear();
  EXPECT_EQ("meshes", refused_field([&] { Detector::create(spec); }));
}

TEST_F(SpecValidation, VertexIndicesAreWithinTheMesh) {
  SceneSpec spec = valid_spec();
  spec.meshes[1].triangles[7][2] = spec.meshes[1].vertex_count;
  const std::string field = refused_field([&] { Detector::create(spec); });
  EXPECT_EQ(0u, field.find("meshes[1].triangles")) << field;
}

TEST_F(SpecValidation, HugeVertexIndexIsRefused) {
  SceneSpec spec = valid_spec();
  spec.meshes[0].triangles[0][0] = ~0u;
  const std::string field = refused_field([&] { Detector::create(spec); });
  EXPECT_EQ(0u, field.find("meshes[0].triangles")) << field;
}

TEST_F(SpecValidation, ATriangleHasThreeVertices) {
  SceneSpec spec = valid_spec();
  spec.meshes[0].triangles[3] = {1, 1, 2};
  const std::string field = refused_field([&] { Detector::create(spec); });
  EXPECT_EQ(0u, field.find("meshes[0].triangles")) << field;
}

TEST_F(SpecValidation, ThreadsAreNotNegative) {
  SceneSpec spec = valid_spec();
  spec.threads = -1;
  EXPECT_EQ("threads", refused_field([&] { Detector::create(spec); }));
}

// Each test breaks one frame after a good one and then checks that the next good one answers as if nothing had been.
class FrameValidation : public OnBackend<> {
 protected:
  void SetUp() override {
    OnBackend::SetUp();
    if (IsSkipped()) return;
    detector_ = Detector::create(valid_spec());
    first_ = detector_->detect(all_.input());
  }

  void expect_refused_unharmed(const FrameInput& bad, const std::string& path) {
    const std::string field = refused_field([&] { detector_->detect(bad); });
    EXPECT_EQ(0u, field.find(path)) << "'" << field << "'";
    EXPECT_FALSE(field.empty()) << "not refused";
    // No start: the meshes are still where the good frame left them.
    FrameInput again = moving_.input();
    again.updates[0].start = {};
    auto twin = Detector::create(valid_spec());
    twin->detect(all_.input());
    EXPECT_TRUE(same_contacts(twin->detect(again), detector_->detect(again)));
  }

  Case case_ = rounded(small_case(), Scalar::kF32);
  Frame all_{case_, Mode::kCcd, Scalar::kF32};
  Frame moving_{case_, Mode::kCcd, Scalar::kF32, false};
  std::unique_ptr<Detector> detector_;
  FrameResult first_;
};

TEST_F(FrameValidation, NotANumberAndInfinity) {
  for (double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    for (bool at_start : {false, true}) {
      Case broken = case_;
      (at_start ? broken.start : broken.end)[0].back()[2] = bad;
      const Frame frame(broken, Mode::kCcd, Scalar::kF32, false);
      expect_refused_unharmed(frame.input(), at_start ? "updates[0].start" : "updates[0].end");
    }
  }
}

TEST_F(FrameValidation, WrongByteLength) {
  FrameInput bad = moving_.input();
  bad.updates[0].end = bad.updates[0].end.subspan(4);
  expect_refused_unharmed(bad, "updates[0].end");
  bad = moving_.input();
  bad.updates[0].start = bad.updates[0].start.first(12);
  expect_refused_unharmed(bad, "updates[0].start");
  bad = moving_.input();
  bad.updates[0].end = {};
  expect_refused_unharmed(bad, "updates[0].end");
}

TEST_F(FrameValidation, UnknownMesh) {
  FrameInput bad = moving_.input();
  bad.updates[0].mesh = 2;
  expect_refused_unharmed(bad, "updates[0].mesh");
  bad.updates[0].mesh = ~0u;
  expect_refused_unharmed(bad, "updates[0].mesh");
}

TEST_F(FrameValidation, AMeshIsNamedOnce) {
  FrameInput bad = moving_.input();
  bad.updates.push_back(bad.updates[0]);
  expect_refused_unharmed(bad, "updates[1]");
}

TEST_F(FrameValidation, AStaticMeshIsNeverSentAgain) {
  FrameInput bad = all_.input();
  expect_refused_unharmed(bad, "updates[1]");
}

TEST_F(FrameValidation, TheFirstFrameNamesEveryMesh) {
  auto fresh = Detector::create(valid_spec());
  const std::string field = refused_field([&] { fresh->detect(moving_.input()); });
  EXPECT_EQ(0u, field.find("updates")) << field;
  EXPECT_TRUE(same_contacts(first_, fresh->detect(all_.input())));
}

TEST_F(FrameValidation, AStartIsNoInputOfDiscreteScenes) {
  SceneSpec spec = valid_spec();
  spec.mode = Mode::kDcd;
  spec.thickness = 0.01;
  auto discrete = Detector::create(spec);
  EXPECT_EQ("updates[0].start", refused_field([&] { discrete->detect(all_.input()); }));
  const Frame frame(case_, Mode::kDcd, Scalar::kF32);
  EXPECT_TRUE(same_contacts(run_case(case_, spec), discrete->detect(frame.input())));
}

}  // namespace
}  // namespace collided::test
