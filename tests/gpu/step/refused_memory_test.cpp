// Each allocation of a frame is refused once: the frame answers all the same, or says that memory is short, and those after
// it know nothing of it.

#include "tests/gpu/backend.hpp"
#include "tests/gpu/refusing_quota.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

struct Settings {
  const char* name;
  Mode mode;
  Accuracy accuracy;
  Reuse reuse;
  Engine engine;
};
void PrintTo(const Settings& settings, std::ostream* out) { *out << settings.name; }

class RefusedMemory : public OnBackend<::testing::TestWithParam<Settings>> {
 protected:
  /// A few contacts, then many more of the same triangles, in larger boxes.
  const Case few_ = soup(160, 150, 0.8, 0.1, 0.01), many_ = soup(161, 150, 0.25, 0.2, 0.1);

  std::unique_ptr<Detector> make(const std::shared_ptr<MemoryQuota>& quota = nullptr) const {
    const Settings& p = GetParam();
    SceneSpec spec = settings(p.mode, p.accuracy, Scalar::kF32, 0.01);
    spec.reuse = p.reuse;
    spec.engine = p.engine;
    spec.threads = 1;
    spec.memory_quota = quota;
    return Detector::create(spec_for(few_, spec));
  }
  FrameResult detect(Detector& detector, const Case& c) const {
    const Frame frame(c, GetParam().mode, Scalar::kF32);
    return detector.detect(frame.input());
  }
};

TEST_P(RefusedMemory, IsToldOrDoneWithout) {
  const auto undisturbed = make();
  const FrameResult few = detect(*undisturbed, few_), many = detect(*undisturbed, many_);
  ASSERT_GT(count_contacts(many), count_contacts(few));
  const Case* const frames[] = {&few_, &many_, &many_};  // where frames make lists, it is the last
  const FrameResult* const expected[] = {&few, &many, &many};
  int told = 0, done_without = 0;
  for (int which = 0; which < 3; ++which) {
    for (int take = 1;; ++take) {
      SCOPED_TRACE("frame " + std::to_string(which) + ", take " + std::to_string(take));
      const auto quota = std::make_shared<RefusingQuota>();
      const auto detector = make(quota);
      for (int before = 0; before < which; ++before) detect(*detector, *frames[before]);
      quota->refuse_at(take);
      try {
        const FrameResult found = detect(*detector, *frames[which]);
        EXPECT_TRUE(same_contacts(*expected[which], found));
        if (!quota->has_refused()) break;
        ++done_without;
      } catch (const ResourceExhausted&) {
        EXPECT_TRUE(quota->has_refused());
        ++told;
      }
      for (int after = 0; after < 4; ++after)
        EXPECT_TRUE(same_contacts(*expected[after % 2], detect(*detector, *frames[after % 2]))) << "after it, " << after;
      if (HasFatalFailure() || HasNonfatalFailure()) return;
    }
  }
  EXPECT_GT(told, 0);
  EXPECT_TRUE(done_without > 0 || GetParam().reuse != Reuse::kOn);  // at least lists can be done without
}

INSTANTIATE_TEST_SUITE_P(
    Frames, RefusedMemory,
    ::testing::Values(Settings{"CcdCertified", Mode::kCcd, Accuracy::kCertified, Reuse::kAuto, Engine::kAuto},
                      Settings{"CcdGuardedWithLists", Mode::kCcd, Accuracy::kGuarded, Reuse::kOn, Engine::kOctree},
                      Settings{"CcdExactByLbvh", Mode::kCcd, Accuracy::kExact, Reuse::kOff, Engine::kLbvh},
                      Settings{"DcdCertifiedWithLists", Mode::kDcd, Accuracy::kCertified, Reuse::kOn, Engine::kLbvh},
                      Settings{"DcdExact", Mode::kDcd, Accuracy::kExact, Reuse::kAuto, Engine::kAuto},
                      Settings{"DcdCandidates", Mode::kDcd, Accuracy::kCandidates, Reuse::kAuto, Engine::kOctree}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace collided::test
