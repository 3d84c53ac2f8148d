// An honest client's latency under attack by another: at the 99th percentile at most 3 times as long as alone plus
// 100 ms. Both values are measured in one run, so that a busy machine affects both.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/integration/fairness/fair_clients.hpp"
#include "tests/support/adversarial.hpp"

namespace collided::test {
namespace {

constexpr double kTimes = 3, kMore = 100;  // ms
constexpr uint64_t kFrames = 100;          // of each measurement
constexpr std::chrono::milliseconds kAlone(500), kBeside(1500), kPatience(5000);

FrameWork forty_scenes() { return layers_work(40, 4); }
FrameWork long_frames() { return layers_work(200, 2); }

FrameWork hostile(const Case& frame, pb::Accuracy accuracy) {
  FrameWork work{.window = 2};
  auto* spec = work.scene.mutable_spec();
  spec->set_mode(pb::DETECTION_MODE_CCD);
  spec->set_position_format(pb::POSITION_FORMAT_F64);
  spec->set_thickness(0.001);
  auto* mesh = spec->add_meshes();
  mesh->set_name("hostile");
  mesh->set_vertex_count(frame.meshes[0].vertex_count);
  for (const auto& triangle : frame.meshes[0].triangles)
    mesh->mutable_triangles()->append(pack(std::vector<uint32_t>(triangle.begin(), triangle.end())));
  auto* update = work.frame.add_updates();
  update->set_start_positions(pack_points(frame.start[0], true));
  update->set_positions(pack_points(frame.end[0], true));
  work.frame.set_accuracy(accuracy);
  return work;
}
FrameWork crowded() { return hostile(crowd(), pb::ACCURACY_CERTIFIED); }
FrameWork exponents_far_apart() { return hostile(far_apart(40), pb::ACCURACY_EXACT); }

struct Attack {
  const char* name;
  int scenes;
  FrameWork (*work)();
};
void PrintTo(const Attack& attack, std::ostream* out) { *out << attack.name; }

/// The 99th percentile.
double p99_of(std::vector<double> all) {
  std::ranges::sort(all);
  return all.empty() ? INFINITY : all[static_cast<size_t>(std::ceil(0.99 * static_cast<double>(all.size()))) - 1];
}

class FairLatency : public NamedClients, public testing::TestWithParam<Attack> {
 protected:
  void SetUp() override {
    if (kIsSanitized) GTEST_SKIP() << "with a sanitizer the engine's steps take many times as long, 100 ms do not";
  }

  /// Latencies of the bystander's frames from now on for so long, in ms; fewer if the daemon makes it wait.
  double p99(std::chrono::milliseconds length) {
    using Clock = std::chrono::steady_clock;
    Bystander& honest = aftermath_.bystander();
    const auto start = Clock::now();
    const uint64_t last = honest.frames() + kFrames;
    honest.take_milliseconds();
    eventually("the time is over or enough frames are answered", [&] {
      return Clock::now() > start + kPatience || (honest.frames() >= last && Clock::now() >= start + length);
    });
    return p99_of(honest.take_milliseconds());
  }

  double p99_beside_attack() {
    const FrameLoad attack(stubs("many", GetParam().scenes), GetParam().work());
    eventually("every scene of the attack has frames that wait",
               [&] { return probe_.metric("collided_queued_frames") >= GetParam().scenes; });
    return p99(kBeside);
  }
};

double bound(double alone) { return kTimes * alone + kMore; }

// Repeated only if the values alone before and after differ so much that the bound depends on it: then the load of the
// machine changed, and the attack's effect is unknown.
TEST_P(FairLatency, IsAtMostThreeTimesThatAloneAndATenthOfASecond) {
  constexpr int kMostTries = 3;
  constexpr double kSteady = 1.25;
  for (int i = 1; i <= kMostTries; ++i) {
    const double before = p99(kAlone), beside = p99_beside_attack();
    probe_.scenes_become(1);
    const double after = p99(kAlone);
    const auto [least, most] = std::minmax(before, after);
    std::printf("p99 in ms: %.1f alone, %.1f during the attack, %.1f alone again\n", before, beside, after);
    if (beside <= bound(most)) break;
    if (i < kMostTries && bound(most) > kSteady * bound(least)) continue;
    ADD_FAILURE() << "99 of 100 frames took up to " << beside << " ms; " << bound(most) << " would be fair";
    break;
  }
  aftermath_.expect_unharmed();
}

INSTANTIATE_TEST_SUITE_P(Attacks, FairLatency,
                         testing::Values(Attack{"forty_scenes", 40, forty_scenes},
                                         Attack{"long_frames", 4, long_frames}, Attack{"crowd", 4, crowded},
                                         Attack{"far_apart", 4, exponents_far_apart}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace collided::test
