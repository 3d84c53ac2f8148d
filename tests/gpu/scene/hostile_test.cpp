// Small frames that are much work: they can be given up at any time, and a budget ends them early.

#include <algorithm>
#include <chrono>
#include <ctime>
#include <functional>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

// A question that counts, measures how long the engine went without it, and says yes at last.
class Question {
 public:
  using Clock = std::chrono::steady_clock;
  explicit Question(int patience) : left_(patience) {}

  bool ask() {
    const auto now = Clock::now();
    longest_ = std::max(longest_, now - last_);
    last_ = now;
    return left_-- == 0;
  }
  bool is_over() const { return left_ < 0; }
  double longest_seconds() const { return std::chrono::duration<double>(longest_).count(); }

 private:
  int left_;
  Clock::time_point last_ = Clock::now();
  Clock::duration longest_{};
};

struct Hostile {
  const char* name;
  Case frame;
  Accuracy accuracy;
  int patience;  ///< asks, on CPU cores
};
void PrintTo(const Hostile& hostile, std::ostream* out) { *out << hostile.name; }

class HostileFrame : public OnBackend<testing::TestWithParam<Hostile>> {
 protected:
  /// A GPU is soon done with the crowd, and asks little before and after its one launch.
  static int patience() {
    constexpr int kOnCuda = 3;
    return kBackend == Backend::kCuda ? std::min(kOnCuda, GetParam().patience) : GetParam().patience;
  }
};

TEST_P(HostileFrame, IsGivenUpSoonAndLeavesTheSceneAsItWas) {
  const Hostile& hostile = GetParam();
  const auto triangles = static_cast<uint32_t>(hostile.frame.meshes[0].triangles.size());
  const Case easy = soup(72, triangles, 1000, 0.1, 0.1);
  const SceneSpec spec = spec_for(easy, settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF64, 0.001));
  auto kept = Detector::create(spec), twin = Detector::create(spec);
  const Frame first(easy, Mode::kCcd, Scalar::kF64), attack(hostile.frame, Mode::kCcd, Scalar::kF64);
  kept->detect(first.input());
  twin->detect(first.input());

  Question question(patience());
  FrameInput input = attack.input();
  input.accuracy = hostile.accuracy;
  input.cancelled = [&] { return question.ask(); };
  EXPECT_THROW(kept->detect(input), Cancelled);
  EXPECT_TRUE(question.is_over());
  EXPECT_LT(question.longest_seconds(), 2);

  FrameInput next = first.input();
  next.updates[0].start = {};
  EXPECT_TRUE(same_contacts(twin->detect(next), kept->detect(next)));
}

TEST_P(HostileFrame, EndsWithWhatTheQuestionThrows) {
  const Hostile& hostile = GetParam();
  auto detector =
      Detector::create(spec_for(hostile.frame, settings(Mode::kCcd, hostile.accuracy, Scalar::kF64, 0.001)));
  const Frame attack(hostile.frame, Mode::kCcd, Scalar::kF64);
  Question question(patience());
  FrameInput input = attack.input();
  input.cancelled = [&] { return question.ask() ? throw std::out_of_range("its time is over") : false; };
  EXPECT_THROW(detector->detect(input), std::out_of_range);
}

// Far more asks than a frame of these has stages, runs of the step included.
INSTANTIATE_TEST_SUITE_P(Frames, HostileFrame,
                         testing::Values(Hostile{"crowd", crowd(), Accuracy::kCertified, 150},
                                         Hostile{"far_apart", far_apart(60), Accuracy::kExact, 100}),
                         [](const auto& info) { return std::string(info.param.name); });

using Budget = OnBackend<>;

// Seconds of all cores together.
double cpu_seconds_of(const std::function<void()>& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

TEST_F(Budget, EndsASearchThatCannotFitIt) {
  const Case spot = soup(70, 1500, 0.01, 0.5, 0.3);
  const Frame attack(spot, Mode::kCcd, Scalar::kF32);
  SceneSpec spec = spec_for(spot, settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32));
  const auto rich = Detector::create(spec);
  const double whole = cpu_seconds_of([&] { rich->detect(attack.input()); });
  spec.memory_budget = 12u << 20;
  const auto poor = Detector::create(spec);
  const double ended = cpu_seconds_of([&] {
    try {
      poor->detect(attack.input());
      FAIL() << "no exception";
    } catch (const ResourceExhausted& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find("needs at least "), std::string::npos) << text;
      EXPECT_NE(text.find("the budget is 12582912"), std::string::npos) << text;
    }
  });
  EXPECT_LT(ended, whole / 2);
}

using StepTime = OnBackend<>;

TEST_F(StepTime, IsThatOfAllRunsAsThatOfTheStages) {
  const Case c = soup(73, 1000, 0.3, 0.2, 0.1);
  SceneSpec spec = spec_for(c, settings(Mode::kCcd, Accuracy::kFast));
  spec.kinds.edge_edge = false;  // kinds go on beside each other on a GPU
  const FrameResult result = Detector::create(spec)->detect(Frame(c, Mode::kCcd, Scalar::kF64).input());
  ASSERT_GT(result.replays, 0u);
  double stages = 0;
  for (const StageTime& stage : result.stages)
    if (stage.stage != "upload" && stage.stage != "download") stages += stage.milliseconds;
  EXPECT_LE(stages, result.step_milliseconds);
  EXPECT_GT(stages, 0);
}

using FrameMessage = OnBackend<>;

std::string refusal(const SceneSpec& spec, const FrameInput& input, int frames = 1) {
  auto detector = Detector::create(spec);
  try {
    for (int i = 0; i < frames; ++i) detector->detect(input);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST_F(FrameMessage, BytesOfTheOtherFormatNameIt) {
  const Case two = soup(74, 2, 1, 0.5, 0.1);
  for (const auto& [scene, sent, expected] :
       {std::tuple(Scalar::kF32, Scalar::kF64,
                   "updates[0].end has 144 bytes; F32 positions of 6 vertices of mesh 0 are 72; 144 is what F64 "
                   "positions take, and the scene is of F32"),
        {Scalar::kF64, Scalar::kF32,
         "updates[0].end has 72 bytes; F64 positions of 6 vertices of mesh 0 are 144; 72 is what F32 positions take, "
         "and the scene is of F64"}}) {
    const SceneSpec spec = spec_for(two, settings(Mode::kDcd, Accuracy::kCertified, scene));
    EXPECT_EQ(refusal(spec, Frame(two, Mode::kDcd, sent).input()), expected);
  }
}

TEST_F(FrameMessage, AStaticMeshThatMovesNamesTheRemedy) {
  Case c = soup(75, 20, 1, 0.5, 0.1);
  add_mesh(c, c.meshes[0].triangles, c.start[0], {}, true);
  const SceneSpec spec = spec_for(c, settings(Mode::kDcd, Accuracy::kCertified));
  const Frame whole(c, Mode::kDcd, Scalar::kF64);
  EXPECT_EQ(refusal(spec, whole.input(), 2),
            "updates[1].mesh 1 is static: its positions come with its first frame alone. Leave it out of later frames, "
            "or create the scene with a deformable mesh");
}

}  // namespace
}  // namespace collided::test
