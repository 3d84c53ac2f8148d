// Scenes whose frames ask for proximity or for contact on the way: the answers of scenes of one kind, from positions
// that are sent once.

#include "tests/gpu/backend.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

Case moving_case() {
  Case c = soup(60, 200, 1, 0.2, 0.1);
  const Case wall = soup(61, 50, 1, 0.3, 0);
  add_mesh(c, wall.meshes[0].triangles, wall.start[0], {}, true);
  return c;
}

class BothModes : public OnBackend<::testing::Test> {
 protected:
  static constexpr double kNear = 0x1p-5, kSeparation = 0x1p-8;

  /// A scene of both, and scenes of one that answer what its frames ask.
  void make(Accuracy accuracy, Scalar scalar, Engine engine = Engine::kAuto) {
    SceneSpec spec = settings(Mode::kBoth, accuracy, scalar, kNear);
    spec.engine = engine;
    spec.min_separation = kSeparation;
    both_ = Detector::create(spec_for(case_, spec));
    spec.mode = Mode::kCcd;
    spec.thickness = kSeparation;
    ccd_ = Detector::create(spec_for(case_, spec));
    spec.mode = Mode::kDcd;
    spec.thickness = kNear;
    spec.min_separation = 0;
    dcd_ = Detector::create(spec_for(case_, spec));
  }
  /// The case between two times, without its start.
  FrameInput at(double t, bool first) {
    Case c = case_;
    for (size_t mesh = 0; mesh < c.end.size(); ++mesh)
      for (size_t i = 0; i < c.end[mesh].size(); ++i)
        for (size_t k = 0; k < 3; ++k)
          c.end[mesh][i][k] = (1 - t) * case_.start[mesh][i][k] + t * case_.end[mesh][i][k];
    frames_.push_back(std::make_unique<Frame>(c, Mode::kDcd, scalar_, first));
    return frames_.back()->input();
  }
  static FrameInput asking(FrameInput input, Mode mode) {
    input.mode = mode;
    return input;
  }

  const Case case_ = moving_case();
  Scalar scalar_ = Scalar::kF64;
  std::vector<std::unique_ptr<Frame>> frames_;
  std::unique_ptr<Detector> both_, ccd_, dcd_;
};

TEST_F(BothModes, EachFrameIsAnsweredAsItAsks) {
  for (const Accuracy accuracy :
       {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact})
    for (const Engine engine : {Engine::kOctree, Engine::kLbvh}) {
      make(accuracy, scalar_, engine);
      for (int step = 0; step < 4; ++step) {
        const FrameInput input = at(step / 3.0, step == 0);
        const FrameResult way = ccd_->detect(input), near = dcd_->detect(input);
        EXPECT_TRUE(same_contacts(way, both_->detect(input))) << "CCD is what a frame gets that does not ask";
        const FrameResult asked = both_->detect(asking({}, Mode::kDcd));
        EXPECT_TRUE(same_contacts(near, asked));
        EXPECT_EQ(1, asked.earliest_toi);
        EXPECT_GT(near.edge_edge.size(), 0u);
        EXPECT_GT(way.edge_edge.size(), 0u);
      }
    }
}

TEST_F(BothModes, ADiscreteFrameMayBringPositionsToo) {
  make(Accuracy::kCertified, scalar_);
  both_->detect(at(0, true)), ccd_->detect(at(0, true));
  const FrameInput half = at(0.5, false), whole = at(1, false);
  FrameInput first = at(0.5, true);
  EXPECT_TRUE(same_contacts(dcd_->detect(first), both_->detect(asking(half, Mode::kDcd))));
  ccd_->detect(half);
  EXPECT_TRUE(same_contacts(ccd_->detect(whole), both_->detect(whole))) << "it begins where the discrete frame was";
}

TEST_F(BothModes, WhatIsNearCanBeAskedWhereAnAdvanceEnded) {
  make(Accuracy::kCertified, scalar_);
  both_->detect(at(0, true)), ccd_->detect(at(0, true));
  FrameInput advance = at(0.2, false);
  advance.advance = true;
  const FrameResult gone = both_->detect(advance);
  EXPECT_EQ(ccd_->detect(advance).advanced, gone.advanced);
  const FrameResult near = both_->detect(asking({}, Mode::kDcd));
  EXPECT_TRUE(same_contacts(near, both_->detect(asking({}, Mode::kDcd)))) << "asking moves nothing";
}

TEST_F(BothModes, WhatDoesNotGoTogetherIsRefused) {
  make(Accuracy::kCertified, scalar_);
  const auto field_of = [](Detector& scene, FrameInput input, Mode mode) {
    input.mode = mode;
    return refused_field([&] { scene.detect(input); });
  };
  const FrameInput first = at(0, true);
  EXPECT_EQ("mode", field_of(*ccd_, first, Mode::kDcd));
  EXPECT_EQ("mode", field_of(*dcd_, first, Mode::kCcd));
  EXPECT_EQ("mode", field_of(*both_, first, Mode::kBoth));
  FrameInput earliest = first, advance = first;
  earliest.report = Report::kEarliestOnly;
  advance.advance = true;
  EXPECT_EQ("report", field_of(*both_, earliest, Mode::kDcd));
  EXPECT_EQ("advance", field_of(*both_, advance, Mode::kDcd));
  SceneSpec triangles = spec_for(case_, settings(Mode::kBoth, Accuracy::kCertified));
  triangles.kinds.triangle_triangle = true;
  EXPECT_EQ("triangle_triangle", refused_field([&] { Detector::create(triangles); }));
}

}  // namespace
}  // namespace collided::test
